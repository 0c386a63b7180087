"""Shader graphs of constants as rows of lobes, and how a row scatters."""

import math

import numpy as np

from photon_engine.issues import RenderError

from .jit import kernel
from .maths import cosine_direction, dot, madd, scale, uniform, unit

NONE, LAMBERT, TRANSLUCENT, MIRROR, GLASS, REFRACTION, TRANSPARENT, EMISSION = range(8)
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


def leaf(node, weight):
    """(kind, colour, ior) of a node without shader inputs."""
    kind = KINDS.get(node.type)
    if kind is None:
        raise RenderError(node.name, f"{node.type} is not known", "use a material that the reference tracer knows")
    if node.type != "ShaderNodeBsdfTranslucent" and constant(node, "Roughness", 0.0) > 0.0:
        raise RenderError(node.name, "roughness is above 0", "the reference tracer knows Lambert and smooth surfaces")
    color = np.asarray(constant(node, "Color", (0.8, 0.8, 0.8)), float)[:3] * weight
    if kind == EMISSION:
        color = color * float(constant(node, "Strength", 1.0))
    return kind, color, float(constant(node, "IOR", 1.5))


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
    return [leaf(node, weight)]


def material_rows(materials):
    """(kinds (M+1, K), colours (M+1, K, 3), iors (M+1, K)); the last row is the grey of a slot without a material."""
    rows = [lobes_of(m.graph, m.graph.surface) for m in materials] + [[(LAMBERT, np.full(3, 0.8), 1.0)]]
    kind = np.zeros((len(rows), MAX_LOBES), np.int32)
    color = np.zeros((len(rows), MAX_LOBES, 3))
    ior = np.ones((len(rows), MAX_LOBES))
    for i, lobes in enumerate(rows):
        if len(lobes) > MAX_LOBES:
            raise RenderError(materials[i].name, f"more than {MAX_LOBES} closures", "simplify the material")
        for k, (what, rgb, index) in enumerate(lobes):
            kind[i, k], color[i, k], ior[i, k] = what, rgb, index
    return kind, color, ior


@kernel
def lobe_color(sc, m, k):
    """Colour of lobe k of material m."""
    return (sc.lobe_color[m, k, 0], sc.lobe_color[m, k, 1], sc.lobe_color[m, k, 2])


@kernel
def summed_color(sc, m, kind):
    """Sum of the colours of all lobes of a kind: emitted radiance, or the transmittance of TRANSPARENT."""
    out = (0.0, 0.0, 0.0)
    for k in range(MAX_LOBES):
        if sc.lobe_kind[m, k] == kind:
            out = madd(out, 1.0, lobe_color(sc, m, k))
    return out


@kernel
def has_rough(sc, m):
    """Whether a material has a rough lobe."""
    for k in range(MAX_LOBES):
        if sc.lobe_kind[m, k] == LAMBERT or sc.lobe_kind[m, k] == TRANSLUCENT:
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
def choose_lobe(sc, m, state):
    """A scattering lobe by the largest component of its colour: (k or -1, probability)."""
    total = 0.0
    for k in range(MAX_LOBES):
        if sc.lobe_kind[m, k] != NONE and sc.lobe_kind[m, k] != EMISSION:
            total += max(lobe_color(sc, m, k))
    if total == 0.0:
        return -1, 1.0
    left = uniform(state) * total
    chosen, p = -1, 0.0
    for k in range(MAX_LOBES):
        q = max(lobe_color(sc, m, k))
        if sc.lobe_kind[m, k] != NONE and sc.lobe_kind[m, k] != EMISSION and q > 0.0 and (chosen < 0 or left >= 0.0):
            chosen, p = k, q / total
            left -= q
    return chosen, p


@kernel
def rough_f(sc, m, wo, wi, ng, ns):
    """BSDF value of all rough lobes, without cosine; ng, ns face wo [1/sr]."""
    out = (0.0, 0.0, 0.0)
    side = dot(wi, ng)
    if side * dot(wi, ns) <= 0.0 or dot(wo, ns) <= 0.0:
        return out
    return scale(summed_color(sc, m, LAMBERT if side > 0.0 else TRANSLUCENT), 1.0 / math.pi)


@kernel
def scatter(sc, m, wo, ng, ns, front, state):
    """What happens to a path at a vertex: (event, wi, weight f |cos| / pdf, eta_t / eta_i crossed).

    ng, ns: normals that face wo; front: whether the ray came from outside. No radiance scaling in weight.
    """
    nothing = (0.0, 0.0, 0.0)
    k, p = choose_lobe(sc, m, state)
    if k < 0:
        return ABSORBED, nothing, nothing, 1.0
    kind, weight = sc.lobe_kind[m, k], scale(lobe_color(sc, m, k), 1.0 / p)
    if kind == TRANSPARENT:
        return NULL, scale(wo, -1.0), weight, 1.0
    if kind == LAMBERT or kind == TRANSLUCENT:
        sign = 1.0 if kind == LAMBERT else -1.0
        wi = cosine_direction(scale(ns, sign), state)
        if dot(wi, ng) * sign <= 0.0 or dot(wo, ns) <= 0.0:
            return ABSORBED, nothing, nothing, 1.0
        return ROUGH, wi, weight, 1.0
    return scatter_sharp(sc.lobe_ior[m, k], kind, wo, ng, ns, front, weight, state)


@kernel
def scatter_sharp(ior, kind, wo, ng, ns, front, weight, state):
    """Mirror, glass or refraction; as `scatter`."""
    nothing = (0.0, 0.0, 0.0)
    cos_i = min(1.0, dot(wo, ns))
    if cos_i <= 0.0:
        return ABSORBED, nothing, nothing, 1.0
    eta = ior if front else 1.0 / ior
    reflectance, cos_t = fresnel(cos_i, eta)
    if kind == MIRROR or (kind == GLASS and uniform(state) < reflectance):
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
