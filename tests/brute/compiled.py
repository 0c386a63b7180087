"""SceneData flattened into the arrays that the reference tracer reads."""

from typing import NamedTuple

import numpy as np

from photon_engine.issues import RenderError

from .bvh import Tree, build_tree
from .lamps import lamp_rows
from .materials import EMISSION, TRANSPARENT, constant, image_rows, material_rows


class Compiled(NamedTuple):
    """World-space triangles, lobes and lights."""

    tree: Tree
    ng: np.ndarray  # (T, 3) f64, unit, outward
    ns: np.ndarray  # (T, 3, 3) f64, unit, per corner
    uv: np.ndarray  # (T, 3, 2) f64, active layer, per corner
    material: np.ndarray  # (T,) i32
    lobe_kind: np.ndarray  # (M, K) i32
    lobe_color: np.ndarray  # (M, K, 3) f64
    lobe_ior: np.ndarray  # (M, K) f64
    lobe_image: np.ndarray  # (M, K) i32, or -1
    texels: np.ndarray  # (N, 3) f64, of all images
    image_info: np.ndarray  # (I, 4) i32: first texel, width, height, whether sRGB
    lamp_kind: np.ndarray  # (L,) i32
    lamps: np.ndarray  # (L, N_FIELDS) f64
    glow: np.ndarray  # (E,) i32, triangles that emit
    glow_cdf: np.ndarray  # (E,) f64, of their power, last entry 1
    glow_pdf: np.ndarray  # (E,) f64, density of a point by area: probability / area [1/m^2]
    area: np.ndarray  # (T,) f64 [m^2]
    world: np.ndarray  # (3,) f64, radiance
    world_centre: np.ndarray  # (3,) f64
    world_radius: float  # of a sphere around all triangles
    light_cdf: np.ndarray  # (L + 2,) f64: choice of a photon's light: lamps, emissive meshes, world
    light_p: np.ndarray  # (L + 2,) f64
    null: bool  # whether any material is see-through


def world_radiance(world):
    """Constant radiance of the world."""
    if world.graph is None or world.graph.surface is None or world.graph.surface.node < 0:
        return np.asarray(world.color if world.graph is None else (0.0, 0.0, 0.0), float)
    node = world.graph.nodes[world.graph.surface.node]
    if node.type != "ShaderNodeBackground":
        raise RenderError(node.name, f"{node.type} as a world", "the reference tracer knows a constant Background")
    return np.asarray(constant(node, "Color", (0, 0, 0)), float)[:3] * float(constant(node, "Strength", 1.0))


def world_triangles(scene):
    """Corners (T, 3, 3), outward normals (T, 3), corner normals (T, 3, 3), uvs (T, 3, 2), materials (T,)."""
    corners, ngs, nss, uvs, materials = [], [], [], [], []
    for instance in scene.instances:
        if instance.holdout or not (instance.visible_camera and instance.visible_shadow):
            raise RenderError(instance.name, "a holdout or hidden from some rays", "show it to all rays")
        mesh = scene.meshes[instance.mesh]
        m = np.asarray(instance.matrix, float)[:3, :3]
        local = mesh.positions.astype(float)[mesh.triangles]
        ng = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0]) @ np.linalg.inv(m)
        ns = np.repeat(ng[:, None], 3, 1) if mesh.normals is None else mesh.normals.astype(float) @ np.linalg.inv(m)
        slot = np.zeros(len(ng), int) if mesh.material_index is None else mesh.material_index
        used = np.asarray(instance.materials or [-1], int)
        corners.append(local @ m.T + np.asarray(instance.matrix, float)[:3, 3])
        ngs.append(ng)
        nss.append(ns)
        uvs.append(np.asarray(mesh.uvs.get(mesh.active_uv, np.zeros((len(ng), 3, 2))), float))
        materials.append(used[np.clip(slot, 0, len(used) - 1)])
    if not corners:
        return [np.zeros((0, *shape)) for shape in ((3, 3), (3,), (3, 3), (3, 2), ())]
    return [np.concatenate(a) for a in (corners, ngs, nss, uvs, materials)]


def compile_scene(scene):
    """The arrays of a scene; a RenderError when it holds what this tracer does not know."""
    corners, ng, ns, uv, material = world_triangles(scene)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    keep = area > 0.0
    if not keep.any():
        # the tree needs a leaf: one black triangle too far to be met
        corners, ng, ns, uv = np.eye(3)[None] + 1e30, np.ones((1, 3)), np.ones((1, 3, 3)), np.zeros((1, 3, 2))
        material, area, keep = np.array([-1]), np.ones(1), np.ones(1, bool)
    tree, order = build_tree(corners[keep])
    corners, ng, ns, uv, material, area = (a[keep][order] for a in (corners, ng, ns, uv, material, area))
    kind, color, ior, image = material_rows(scene.materials)
    material = np.where(material < 0, len(scene.materials), material).astype(np.int32)
    le = np.where(kind == EMISSION, 1.0, 0.0)[..., None] * color
    power = le.sum(1).max(1)[material] * area
    glow = np.flatnonzero(power > 0.0).astype(np.int32)
    share = power[glow] / max(power.sum(), 1e-300)
    lamp_kind, lamps = lamp_rows(scene.lights)
    lo, hi = corners.min((0, 1)), corners.max((0, 1))
    cdf, p = light_choice(scene, world_radiance(scene.world), 2 * np.pi * power.sum(), np.linalg.norm(hi - lo) / 2)
    normalized = [a / np.linalg.norm(a, axis=-1, keepdims=True) for a in (ng, ns)]
    return Compiled(
        tree, *normalized, uv, material, kind, color, ior, image, *image_rows(scene.images), lamp_kind,
        lamps, glow, np.cumsum(share), share / area[glow],
        area, world_radiance(scene.world), (lo + hi) / 2, float(np.linalg.norm(hi - lo) / 2), cdf, p,
        bool((kind == TRANSPARENT).any()),
    )


def light_choice(scene, world, mesh_power, radius):
    """(cdf, p) of choosing a lamp, the emissive meshes or the world, by power."""
    disk = np.pi * radius * radius
    power = [max(x.strength) * (disk if x.kind == "SUN" else 1.0) for x in scene.lights]
    power = np.array([*power, mesh_power, 4.0 * np.pi * world.max() * disk], float)
    p = power / max(power.sum(), 1e-300)
    return np.cumsum(p), p
