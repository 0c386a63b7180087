import numpy as np
import pytest

from ...scene.data import Image
from .. import textures as tx


def fold(k, n):
    """An index reflected at 0 and n."""
    return k % n if (k // n) % 2 == 0 else n - 1 - k % n


def naive(pixels, u, v, extension):
    """Bilinear lookup by the definition: texels at halves, indices wrapped one by one."""
    height, width = pixels.shape[:2]

    def texel(i, j):
        if extension == "REPEAT":
            return pixels[j % height, i % width]
        if extension == "EXTEND":
            return pixels[np.clip(j, 0, height - 1), np.clip(i, 0, width - 1)]
        if extension == "MIRROR":
            return pixels[fold(j, height), fold(i, width)]
        return pixels[j, i] if 0 <= i < width and 0 <= j < height else np.zeros(4)

    x, y = u * width - 0.5, v * height - 0.5
    i, j = int(np.floor(x)), int(np.floor(y))
    s, t = x - i, y - j
    rows = [(1 - s) * texel(i, j + k) + s * texel(i + 1, j + k) for k in (0, 1)]
    return (1 - t) * rows[0] + t * rows[1]


@pytest.mark.parametrize("extension", tx.EXTENSIONS)
def test_bilinear_equals_definition(extension):
    rng = np.random.default_rng(1)
    pixels = rng.random((5, 7, 4), np.float32)
    uv = rng.uniform(-3.0, 4.0, (2, 300)).astype(np.float32)
    out = tx.sample_image(pixels, uv, tx.LINEAR, tx.EXTENSIONS[extension], 0)
    expected = [naive(pixels.astype(float), float(u), float(v), extension) for u, v in uv.T]
    np.testing.assert_allclose(out.T, expected, atol=1e-6)


@pytest.mark.parametrize("mode", tx.INTERPOLATIONS.values())
@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "MIRROR"])
def test_flat_image_stays_flat(mode, extension):
    """Weights sum to 1, beyond the borders too."""
    pixels = np.full((3, 4, 4), 0.7, np.float32)
    uv = np.random.default_rng(2).uniform(-9.0, 9.0, (2, 500)).astype(np.float32)
    out = tx.sample_image(pixels, uv, mode, tx.EXTENSIONS[extension], 0)
    np.testing.assert_allclose(out, 0.7, rtol=1e-6)


def test_bytes_equal_floats():
    rng = np.random.default_rng(3)
    pixels = rng.integers(0, 256, (6, 5, 4), np.uint8)
    uv = rng.random((2, 200), np.float32)
    for mode in tx.INTERPOLATIONS.values():
        whole = tx.sample_image(pixels, uv, mode, tx.REPEAT, tx.DECODE | tx.UNPREMULTIPLY)
        floats = tx.sample_image((pixels / 255.0).astype(np.float32), uv, mode, tx.REPEAT, tx.DECODE | tx.UNPREMULTIPLY)
        np.testing.assert_allclose(whole, floats, rtol=1e-5, atol=1e-6)


def test_decode_is_the_srgb_curve():
    """Also beyond [0, 1], where unpremultiplied colours can lie."""
    values = np.linspace(0.0, 3.0, 20001)
    ours = np.array([tx.decode(float(x), tx.DECODE_TABLE) for x in values])
    # the table's entries are float32: 6e-8 near 1, and its chords are off by 2.4e-8
    np.testing.assert_allclose(ours, tx.srgb_to_linear(values), atol=2e-7)
    np.testing.assert_allclose(tx.linear_to_srgb(tx.srgb_to_linear(values)), values, atol=1e-6)


def test_far_and_broken_coordinates():
    pixels = np.random.default_rng(4).random((4, 4, 4), np.float32)
    uv = np.array([[np.nan, 0.5], [np.inf, 0.0], [1e30, -1e30], [2e7, 0.3]], np.float32).T
    for mode in tx.INTERPOLATIONS.values():
        for extension in tx.EXTENSIONS.values():
            assert np.isfinite(tx.sample_image(pixels, uv, mode, extension, 0)).all()


def test_memory_of_textures():
    """Tiled images have no pixels of their own."""
    bytes_and_floats = [Image("A", np.zeros((2, 3, 4), np.float32)), Image("B", np.zeros((5, 1, 4), np.uint8))]
    images = [*bytes_and_floats, Image("C", tiles={1: 0})]
    assert tx.texture_bytes(images) == 2 * 3 * 4 * 4 + 5 * 4
