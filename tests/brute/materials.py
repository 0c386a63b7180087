"""Shader graphs of constants as rows of lobes, and how a row scatters."""

import math

import numpy as np

from photon_engine.issues import RenderError

from .jit import kernel
from .maths import cosine_direction, dot, madd, mul, scale, uniform, unit

NONE, LAMBERT, TRANSLUCENT, MIRROR, GLASS, REFRACTION, TRANSPARENT, EMISSION, METAL = range(9)
MAX_LOBES = 6

NULL, SHARP, ROUGH, ABSORBED = range(4)  # what became of a path at a vertex

KINDS = {
    "ShaderNodeBsdfDiffuse": LAMBERT,
    "ShaderNodeBsdfTranslucent": TRANSLUCENT,
    "ShaderNodeBsdfGlossy": MIRROR,
    "ShaderNodeBsdfAnisotropic": MIRROR,
    "ShaderNodeBsdfGlass": GLASS,
    "ShaderNodeBsdfRefraction": REFRACTION,
    "ShaderNodeBsdfTransparent": TRANSPARENT,
    "ShaderNodeEmission": EMISSION,
}


def constant(node, name, default):
    """The constant value of an input; a link is refused."""
    socket = node.inputs.get(name)
    if socket is None or (socket.value is None and socket.node < 0):
        return default
    if socket.node >= 0:
        raise RenderError(node.name, f"input {name} is linked", "the reference tracer knows only constants")
    return socket.value


def metal(node, weight):
    """A polished Principled metal: Schlick's Fresnel [1994] of the base colour; the tint at the rim must be white."""
    wanted = {"Metallic": 1.0, "Roughness": 0.0, "Alpha": 1.0, "Coat Weight": 0.0, "Sheen Weight": 0.0,
              "Emission Strength": 0.0, "Anisotropic": 0.0, "Thin Film Thickness": 0.0}
    for name, value in wanted.items():
        if constant(node, name, value) != value:
            raise RenderError(node.name, f"{name} is not {value:g}", "the reference tracer knows only polished metal")
    if tuple(constant(node, "Specular Tint", (1.0, 1.0, 1.0)))[:3] != (1.0, 1.0, 1.0):
        raise RenderError(node.name, "a specular tint", "the reference tracer knows only white")
    if weight != 1.0:
        raise RenderError(node.name, "metal in a mixture", "the reference tracer knows only pure metal")
    return METAL, np.asarray(constant(node, "Base Color", (0.8,) * 3), float)[:3], 1.0, -1


def leaf(graph, node, weight):
    """(kind, colour, ior, image or -1) of a node without shader inputs."""
    if node.type == "ShaderNodeBsdfPrincipled":
        return metal(node, weight)
    kind = KINDS.get(node.type)
    if kind is None:
        raise RenderError(node.name, f"{node.type} is not known", "use a material that the reference tracer knows")
    if node.type != "ShaderNodeBsdfTranslucent" and constant(node, "Roughness", 0.0) > 0.0:
        raise RenderError(node.name, "roughness is above 0", "the reference tracer knows Lambert and smooth surfaces")
    link = node.inputs.get("Color")
    if link is not None and link.node >= 0 and kind != EMISSION:
        return kind, np.full(3, weight), float(constant(node, "IOR", 1.5)), image_of(graph.nodes[link.node])
    color = np.asarray(constant(node, "Color", (0.8, 0.8, 0.8)), float)[:3] * weight
    if kind == EMISSION:
        color = color * float(constant(node, "Strength", 1.0))
    return kind, color, float(constant(node, "IOR", 1.5)), -1


def image_of(node):
    """Index of the image of a plain texture node: active UV layer, repeated, bilinear."""
    vector = node.inputs.get("Vector")
    plain = node.type == "ShaderNodeTexImage" and (vector is None or vector.node < 0)
    if not (plain and node.props["extension"] == "REPEAT" and node.props["interpolation"] == "Linear"):
        raise RenderError(node.name, "colour from a node", "the reference tracer knows only plain image textures")
    return node.props["image"]


def lobes_of(graph, socket, weight=1.0):
    """All lobes that a shader socket leads to, with the weights of mixtures multiplied in."""
    if socket is None or socket.node < 0 or weight == 0.0:
        return []
    node = graph.nodes[socket.node]
    if node.type in ("ShaderNodeMixShader", "ShaderNodeAddShader"):
        a, b = 1.0, 1.0
        if node.type == "ShaderNodeMixShader":
            b = float(np.clip(constant(node, "Factor" if "Factor" in node.inputs else "Fac", 0.5), 0.0, 1.0))
            a = 1.0 - b
        first, second = node.inputs.get("Shader"), node.inputs.get("Shader_001")
        return lobes_of(graph, first, weight * a) + lobes_of(graph, second, weight * b)
    return [leaf(graph, node, weight)]


def material_rows(materials):
    """Kinds (M+1, K), colours (M+1, K, 3), iors and images (M+1, K); the last row: a slot without a material."""
    rows = [lobes_of(m.graph, m.graph.surface) for m in materials] + [[(LAMBERT, np.full(3, 0.8), 1.0, -1)]]
    kind = np.zeros((len(rows), MAX_LOBES), np.int32)
    color = np.zeros((len(rows), MAX_LOBES, 3))
    ior = np.ones((len(rows), MAX_LOBES))
    image = np.full((len(rows), MAX_LOBES), -1, np.int32)
    for i, lobes in enumerate(rows):
        if len(lobes) > MAX_LOBES:
            raise RenderError(materials[i].name, f"more than {MAX_LOBES} closures", "simplify the material")
        for k, lobe in enumerate(lobes):
            kind[i, k], color[i, k], ior[i, k], image[i, k] = lobe
    return kind, color, ior, image


def image_rows(images):
    """Pixels of all images as one list (N, 3), as they are stored, and (first, width, height, is sRGB) of each."""
    pixels, info, first = [np.zeros((1, 3))], [(0, 1, 1, 0)], 1
    for image in images:
        pixels_in = np.ones((1, 1, 4)) if image.pixels is None else image.pixels
        rgb = pixels_in[:, :, :3] / (255.0 if pixels_in.dtype == np.uint8 else 1.0)
        info.append((first, rgb.shape[1], rgb.shape[0], int(image.encoded)))
        pixels.append(rgb.reshape(-1, 3))
        first += len(pixels[-1])
    return np.concatenate(pixels), np.array(info[1:] or info, np.int32)


@kernel
def texel_mean(sc, image, u, v):
    """Bilinear mean of a repeated image at (u, v), linear."""
    first, width, height, encoded = sc.image_info[image]
    x, y = u * width - 0.5, v * height - 0.5
    x0, y0 = math.floor(x), math.floor(y)
    out = (0.0, 0.0, 0.0)
    for dy in range(2):
        for dx in range(2):
            w = (x - x0 if dx else 1.0 - (x - x0)) * (y - y0 if dy else 1.0 - (y - y0))
            texel = first + (int(y0) + dy) % height * width + (int(x0) + dx) % width
            out = madd(out, w, (sc.texels[texel, 0], sc.texels[texel, 1], sc.texels[texel, 2]))
    if encoded:
        return (linear(out[0]), linear(out[1]), linear(out[2]))
    return out


@kernel
def linear(x):
    """Linear value of an sRGB one [IEC 61966-2-1]."""
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


@kernel
def lobe_color(sc, at, k):
    """Colour of lobe k at a place (material, u, v)."""
    m, u, v = at
    color = (sc.lobe_color[m, k, 0], sc.lobe_color[m, k, 1], sc.lobe_color[m, k, 2])
    if sc.lobe_image[m, k] < 0:
        return color
    return mul(color, texel_mean(sc, sc.lobe_image[m, k], u, v))


@kernel
def summed_color(sc, at, kind):
    """Sum of the colours of all lobes of a kind at a place: emitted radiance, or the transmittance of TRANSPARENT."""
    out = (0.0, 0.0, 0.0)
    for k in range(MAX_LOBES):
        if sc.lobe_kind[at[0], k] == kind:
            out = madd(out, 1.0, lobe_color(sc, at, k))
    return out


@kernel
def has_rough(sc, at):
    """Whether a material has a rough lobe."""
    for k in range(MAX_LOBES):
        if sc.lobe_kind[at[0], k] == LAMBERT or sc.lobe_kind[at[0], k] == TRANSLUCENT:
            return True
    return False


@kernel
def fresnel(cos_i, eta):
    """(reflectance, cosine of refraction) of unpolarised light; eta = eta_t / eta_i [Born and Wolf 1999, 1.5.2]."""
    sin2_t = (1.0 - cos_i * cos_i) / (eta * eta)
    if sin2_t >= 1.0:
        return 1.0, 0.0
    cos_t = math.sqrt(1.0 - sin2_t)
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return 0.5 * (s * s + p * p), cos_t


@kernel
def mirrored(w, n):
    """w mirrored about n."""
    return madd(scale(w, -1.0), 2.0 * dot(w, n), n)


@kernel
def choose_lobe(sc, at, state):
    """A scattering lobe by the largest component of its colour: (k or -1, probability)."""
    total = 0.0
    for k in range(MAX_LOBES):
        if sc.lobe_kind[at[0], k] != NONE and sc.lobe_kind[at[0], k] != EMISSION:
            total += max(lobe_color(sc, at, k))
    if total == 0.0:
        return -1, 1.0
    left = uniform(state) * total
    chosen, p = -1, 0.0
    for k in range(MAX_LOBES):
        q = max(lobe_color(sc, at, k))
        scatters = sc.lobe_kind[at[0], k] != NONE and sc.lobe_kind[at[0], k] != EMISSION and q > 0.0
        if scatters and (chosen < 0 or left >= 0.0):
            chosen, p = k, q / total
            left -= q
    return chosen, p


@kernel
def rough_f(sc, at, wo, wi, ng, ns):
    """BSDF value of all rough lobes, without cosine; ng, ns face wo [1/sr]."""
    out = (0.0, 0.0, 0.0)
    side = dot(wi, ng)
    if side * dot(wi, ns) <= 0.0 or dot(wo, ns) <= 0.0:
        return out
    return scale(summed_color(sc, at, LAMBERT if side > 0.0 else TRANSLUCENT), 1.0 / math.pi)


@kernel
def scatter(sc, at, wo, ng, ns, front, state):
    """What happens to a path at a vertex: (event, wi, weight f |cos| / pdf, eta_t / eta_i crossed).

    ng, ns: normals that face wo; front: whether the ray came from outside. No radiance scaling in weight.
    """
    nothing = (0.0, 0.0, 0.0)
    k, p = choose_lobe(sc, at, state)
    if k < 0:
        return ABSORBED, nothing, nothing, 1.0
    kind, weight = sc.lobe_kind[at[0], k], scale(lobe_color(sc, at, k), 1.0 / p)
    if kind == TRANSPARENT:
        return NULL, scale(wo, -1.0), weight, 1.0
    if kind == LAMBERT or kind == TRANSLUCENT:
        sign = 1.0 if kind == LAMBERT else -1.0
        wi = cosine_direction(scale(ns, sign), state)
        if dot(wi, ng) * sign <= 0.0 or dot(wo, ns) <= 0.0:
            return ABSORBED, nothing, nothing, 1.0
        return ROUGH, wi, weight, 1.0
    return scatter_sharp(sc.lobe_ior[at[0], k], kind, wo, ng, ns, front, lobe_color(sc, at, k), p, state)


@kernel
def scatter_sharp(ior, kind, wo, ng, ns, front, color, p, state):
    """Mirror, metal, glass or refraction, chosen with probability p; as `scatter`."""
    nothing, weight = (0.0, 0.0, 0.0), scale(color, 1.0 / p)
    cos_i = min(1.0, dot(wo, ns))
    if cos_i <= 0.0:
        return ABSORBED, nothing, nothing, 1.0
    if kind == METAL:
        weight = madd(weight, (1.0 - cos_i) ** 5 / p, (1.0 - color[0], 1.0 - color[1], 1.0 - color[2]))
    eta = ior if front else 1.0 / ior
    reflectance, cos_t = fresnel(cos_i, eta)
    if kind == MIRROR or kind == METAL or (kind == GLASS and uniform(state) < reflectance):
        wi = mirrored(wo, ns)
        if dot(wi, ng) <= 0.0:
            return ABSORBED, nothing, nothing, 1.0
        return SHARP, wi, weight, 1.0
    if reflectance == 1.0:
        return ABSORBED, nothing, nothing, 1.0
    wi = unit(madd(scale(wo, -1.0 / eta), cos_i / eta - cos_t, ns))
    if dot(wi, ng) >= 0.0:
        return ABSORBED, nothing, nothing, 1.0
    return SHARP, wi, weight, eta
