"""Image lookups against Cycles: borders, filters, colour spaces, alpha, files."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
oiio = pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, TOLERANCE, Patch, enum, feed, new, out, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


def make_image(folder, kind: str, space: str = "", alpha: str = "STRAIGHT", channels: int = 4):
    """An 8 x 5 image of random texels: generated or written to a file by format name, then loaded."""
    rng = np.random.default_rng(7)
    texels = rng.random((5, 8, 4), np.float32)
    texels[..., 3] = np.where(rng.random((5, 8)) < 0.3, 1.0, 0.1 + 0.8 * texels[..., 3])
    if alpha == "PREMUL":
        texels[..., :3] *= texels[..., 3:4]
    if kind.startswith("GENERATED"):
        image = bpy.data.images.new("Texture", 8, 5, alpha=True, float_buffer="FLOAT" in kind)
        _settings(image, space, alpha)  # before the texels: a change of colour space makes them anew
        image.pixels.foreach_set(texels.ravel())
        image.update()
    else:
        extension, _, depth = kind.partition(" ")
        path = folder / f"texture_{len(bpy.data.images)}.{extension.lower()}"
        spec = oiio.ImageSpec(8, 5, channels, depth or "uint8")
        spec.attribute("oiio:UnassociatedAlpha", 1)
        file = oiio.ImageOutput.create(str(path))
        file.open(str(path), spec)
        file.write_image(np.ascontiguousarray(texels[::-1, :, :channels]))
        file.close()
        image = bpy.data.images.load(str(path))
        _settings(image, space, alpha)
    return image


def _settings(image, space: str, alpha: str) -> None:
    """Colour space and alpha mode."""
    if space:
        image.colorspace_settings.name = space
    image.alpha_mode = alpha


def texture(tree, image, vector=None, **settings):
    """An Image Texture node."""
    node = new(tree, "ShaderNodeTexImage", image=image, **settings)
    return node if vector is None else feed(tree, node, Vector=vector)


@pytest.mark.parametrize("extension", enum("ShaderNodeTexImage", "extension"))
@pytest.mark.parametrize("interpolation", enum("ShaderNodeTexImage", "interpolation"))
def test_image_lookup(patch, interpolation, extension):
    """Every interpolation and extension, well beyond the borders."""
    image = make_image(patch.folder, "GENERATED FLOAT", alpha="NONE")

    def build(tree):
        return texture(tree, image, ramp(tree, (-1.3, -2.4, 0.0), (2.2, 1.9, 0.0)), interpolation=interpolation,
                       extension=extension).outputs[0]

    # 28 x 21 texels over the patch: a texel is a pixel wide, so the filter's shift moves values by 0.005 of a step
    patch.compare(build, 1e-3, outliers=EDGES if interpolation == "Closest" or extension == "CLIP" else 0)


@pytest.mark.parametrize(("alpha", "output"), [("STRAIGHT", "Color"), ("STRAIGHT", "Alpha"), ("STRAIGHT", "both"),
                                               ("PREMUL", "both"), ("CHANNEL_PACKED", "both"), ("NONE", "both")])
@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Linear Rec.709", "Linear Rec.2020"])
@pytest.mark.parametrize("kind", ["GENERATED", "GENERATED FLOAT", "PNG", "PNG uint16", "EXR float", "packed PNG",
                                  "packed PNG uint16", "packed EXR float"])
def test_image_colors(patch, kind, space, alpha, output):
    """Colour spaces and alpha modes of byte and float images, read for colour, alpha, or both."""
    image = make_image(patch.folder, kind.removeprefix("packed "), space, alpha)
    if kind.startswith("packed"):
        image.pack()

    def build(tree):
        node = texture(tree, image, ramp(tree, (0.06, 0.1, 0.0), (0.96, 0.85, 0.0)))
        if output != "both":
            return out(node, output)
        mix = new(tree, "ShaderNodeMix", data_type="RGBA")
        feed(tree, mix, Factor_Float=0.5, A_Color=node.outputs["Color"], B_Color=node.outputs["Alpha"])
        return out(mix, "Result_Color")

    # texels differ by up to 1 within 4 pixels; converted colour spaces are kept as half floats by Cycles (5e-4)
    patch.compare(build, 2.0 * TOLERANCE)


def test_missing_file_is_magenta(patch):
    image = make_image(patch.folder, "PNG")
    image.filepath = str(patch.folder / "gone.png")
    image.reload()
    issues = patch.compare(lambda tree: texture(tree, image).outputs[0], flat=True)
    assert any("gone.png does not exist" in str(issue) for issue in issues)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_no_image(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeTexImage"), output), flat=True)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
@pytest.mark.parametrize("channels", [1, 2, 3])
def test_channels(patch, channels, output):
    """Grey files, with alpha and without."""
    image = make_image(patch.folder, "PNG", channels=channels)
    opaque = output == "Alpha" and channels != 2
    patch.compare(lambda tree: out(texture(tree, image), output), 2.0 * TOLERANCE, flat=opaque)


@pytest.mark.parametrize("projection", ["SPHERE", "TUBE"])
def test_projection(patch, projection):
    image = make_image(patch.folder, "GENERATED FLOAT", alpha="NONE")

    def build(tree):
        return texture(tree, image, ramp(tree, (-0.4, 0.1, 0.2), (1.5, 1.2, 0.9)), projection=projection).outputs[0]

    patch.compare(build, 1e-3, outliers=EDGES)  # around the poles the angle changes fast


@pytest.mark.parametrize("blend", [0.0, 0.5, 1.0])
def test_box_projection(patch, blend):
    """On a ball: every side of the box, and every mix of two and three."""
    image = make_image(patch.folder, "GENERATED FLOAT", alpha="NONE")
    plane = patch.object.data
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.7)
    ball = bpy.context.object
    ball.data.materials.append(patch.material)
    patch.object.hide_render = True
    ball.rotation_euler = (0.4, 0.3, 0.8)

    def build(tree):
        place = out(tree.nodes.new("ShaderNodeTexCoord"), "Object")
        return texture(tree, image, place, projection="BOX", projection_blend=blend).outputs[0]

    # without a blend sides jump, and facets and the outline are edges
    patch.compare_engine(build, outliers=4)
    bpy.data.objects.remove(ball)
    patch.object.hide_render = False
    assert patch.object.data == plane


@pytest.mark.parametrize("projection", enum("ShaderNodeTexEnvironment", "projection"))
@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic"])
def test_environment(patch, projection, interpolation):
    image = make_image(patch.folder, "PNG", alpha="NONE")

    def build(tree):
        node = new(tree, "ShaderNodeTexEnvironment", image=image, projection=projection, interpolation=interpolation)
        return feed(tree, node, Vector=ramp(tree, (-0.7, -0.9, -0.3), (0.8, 0.7, 0.6))).outputs[0]

    patch.compare(build, 1e-3, outliers=EDGES)


def save_tile(path, seed: int) -> None:
    """A small PNG of random texels."""
    texels = np.random.default_rng(seed).integers(0, 256, (5, 8, 3), np.uint8)
    file = oiio.ImageOutput.create(str(path))
    file.open(str(path), oiio.ImageSpec(8, 5, 3, "uint8"))
    file.write_image(texels)
    file.close()


def test_tiles(patch):
    """UDIM: three tiles, and magenta where there is none."""
    for number in (1001, 1002, 1011):
        save_tile(patch.folder / f"tiles.{number}.png", number)
    image = bpy.data.images.load(str(patch.folder / "tiles.1001.png"))
    image.source = "TILED"
    image.filepath = str(patch.folder / "tiles.<UDIM>.png")
    for number in (1002, 1011):
        image.tiles.new(tile_number=number)

    def build(tree):
        return texture(tree, image, ramp(tree, (-0.31, -0.27, 0.0), (2.6, 2.3, 0.0)), extension="EXTEND").outputs[0]

    patch.compare(build, 1e-3, outliers=EDGES)  # edges of tiles


@pytest.mark.parametrize("cyclic", [False, True])
@pytest.mark.parametrize("frame", [1, 4, 9])
def test_sequence(patch, frame, cyclic):
    for number in range(10, 15):
        save_tile(patch.folder / f"film_{number:04d}.png", number)
    image = bpy.data.images.load(str(patch.folder / "film_0010.png"))
    image.source = "SEQUENCE"
    patch.scene.frame_set(frame)

    def build(tree):
        node = texture(tree, image, ramp(tree, (0.06, 0.1, 0.0), (0.96, 0.85, 0.0)))
        user = node.image_user
        user.frame_duration, user.frame_start, user.frame_offset, user.use_cyclic = 3, 2, 10, cyclic
        user.use_auto_refresh = True
        return node.outputs[0]

    try:
        patch.compare(build, 1e-3)
    finally:
        patch.scene.frame_set(1)
