"""What a node program may ask about the surface points it shades."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np

from ..scene.data import Instance
from .trail import FROM_LIGHT


@dataclass
class ObjectTable:
    """What nodes may ask about the instances of a scene, one row for each."""

    matrix: np.ndarray  # (I, 3, 3) f32, object to world, linear part
    inverse: np.ndarray  # (I, 3, 3) f32, its inverse (pseudo-inverse of a flattened object)
    location: np.ndarray  # (I, 3) f64, object's origin in the world [m]
    color: np.ndarray  # (I, 4) f32
    pass_index: np.ndarray  # (I,) f32
    random: np.ndarray  # (I,) f32
    particle: np.ndarray = field(default_factory=lambda: np.zeros((1, 13), np.float32))  # (I, 13), Instance.particle
    attributes: dict[str, np.ndarray] = field(default_factory=dict)  # "OBJECT:name", ... -> (I, 4) f32

    @classmethod
    def from_instances(cls, instances) -> ObjectTable:
        """The table of a scene's list of instances."""
        matrices = [item.matrix if item.object_matrix is None else item.object_matrix for item in instances]
        linear = np.array([m[:3, :3] for m in matrices], np.float64).reshape(-1, 3, 3)
        return cls(
            matrix=linear.astype(np.float32),
            inverse=np.linalg.pinv(linear).astype(np.float32) if len(linear) else linear.astype(np.float32),
            location=np.array([m[:3, 3] for m in matrices], np.float64).reshape(-1, 3),
            color=np.array([item.color for item in instances], np.float32).reshape(-1, 4),
            pass_index=np.array([item.pass_index for item in instances], np.float32),
            random=np.array([item.random for item in instances], np.float32),
            particle=np.array([item.particle or (0.0,) * 13 for item in instances], np.float32).reshape(-1, 13),
            attributes={
                name: np.array([item.attributes.get(name, (0.0,) * 4) for item in instances], np.float32)
                for name in frozenset().union(*(item.attributes for item in instances))
            },
        )


NO_OBJECT = ObjectTable.from_instances([Instance(0, np.eye(4), [], color=(0.0,) * 4)])  # the world: all zeros


class Around(Protocol):
    """Points beside those that are shaded: where a bump looks for the slope of its height."""

    dp: tuple[np.ndarray, np.ndarray]  # two (n, 3) f32 across the geometric normal, a pixel long [m]

    def at(self, axis: int, width: float) -> ShadePoints:
        """The points moved by width times dp[axis]; positions and coordinates move, normals do not."""
        ...


class Rays(Protocol):
    """Ray queries from shaded points; d (n, 3) need not be unit, t_max (n,) is in its lengths.

    Positions have the points' `origin`.
    """

    def free(self, points: ShadePoints, d: np.ndarray, t_max: np.ndarray, own: bool) -> np.ndarray:
        """(n,) bool: nothing, or with `own` nothing of the point's own object, within t_max along d."""
        ...

    def nearest(self, points: ShadePoints, o: np.ndarray | None, d: np.ndarray, t_max: np.ndarray, own: bool) -> tuple:
        """(hit, t, self, n): what rays from o, or from the points, meet first."""
        ...

    def crossings(
        self, points: ShadePoints, o: np.ndarray, d: np.ndarray, t_max: np.ndarray, most: int
    ) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """(index, p, ng, ns) of the first, second, ... crossings of rays from o with the points' own objects."""
        ...


@dataclass
class ShadePoints:
    """n hits of one material. Only what the program's `needs` names has to be filled in beyond the first five.

    Normals face outward, whatever side was hit, as everywhere outside `shading/`.
    """

    p: np.ndarray  # (n, 3) f32, recentred: less `origin` [m]
    ng: np.ndarray  # (n, 3) f32, unit
    ns: np.ndarray  # (n, 3) f32, unit
    wo: np.ndarray  # (n, 3) f32, unit, to where the path came from
    backfacing: np.ndarray  # (n,) bool, dot(wo, ng) < 0
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) f64, of `p` in the world [m]
    uvs: dict[str, np.ndarray] = field(default_factory=dict)  # layer ("" is the active one) -> (n, 2) f32
    generated: np.ndarray | None = None  # (n, 3) f32
    object: np.ndarray | None = None  # (n, 3) f32, p in the object's space
    normal_local: np.ndarray | None = None  # (n, 3) f32, interpolated corner normals in mesh space, not normalised
    tangents: dict[str, np.ndarray] = field(default_factory=dict)  # layer -> (n, 4) f32, mesh space, w: sign
    attributes: dict[str, np.ndarray] = field(default_factory=dict)  # name -> (n, 5) f32: rgba, Fac
    corners: np.ndarray | None = None  # (n, 3, 3) f32, of the triangle, from the point [m]
    parametric: np.ndarray | None = None  # (n, 2) f32, barycentric coordinates of corners 1 and 2
    island_random: np.ndarray | None = None  # (n,) f32, Geometry > Random Per Island
    instance: np.ndarray | None = None  # (n,) i32, row of `objects`
    objects: ObjectTable | None = None
    camera: np.ndarray | None = None  # (4, 4) f32, from `p` to the camera's space with z along the view axis
    window: tuple[float, ...] | None = None  # left, right, bottom, top of Camera.window, 1 for perspective
    trail: np.ndarray | None = None  # (n,) i64, of eye paths: shading/trail.py; None: light is sampled
    ray_length: np.ndarray | None = None  # (n,) f32, of an eye path's last ray [m]
    is_photon: bool = False  # the path came from a light
    is_shadow: bool = False  # only transparency is asked
    is_lamp: bool = False  # they are on a lamp, `ray_length` from what it lights
    rays: Any = None  # Rays: what lies near ("rays" in needs); None: nothing is known, as before a scene has its tree
    around: Any = None  # Around: neighbours for bump ("bump" in needs); None: there is no telling a slope

    def __len__(self) -> int:
        """Number of points."""
        return len(self.p)

    def world(self) -> np.ndarray:
        """Positions in the world (n, 3) f32: far from the origin of coarser steps than `p`."""
        return (self.p + self.origin).astype(np.float32)

    def to_space(self, inverse: np.ndarray) -> np.ndarray:
        """What takes `p` to a space (4, 4) f32, from world to that space (4, 4): rounded only when all is composed."""
        out = np.array(inverse, np.float64)
        out[:3, 3] += out[:3, :3] @ self.origin
        return out.astype(np.float32)

    def facing(self, normals: np.ndarray) -> np.ndarray:
        """Normals (n, 3) turned to the side that was hit, as nodes see them."""
        if not self.backfacing.any():
            return normals
        return np.where(self.backfacing[:, None], -normals, normals)

    def take(self, index: np.ndarray) -> ShadePoints:
        """The points of an index or mask array."""
        picked = {}
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, dict):
                value = {name: rows[index] for name, rows in value.items()}
            elif isinstance(value, np.ndarray) and item.name not in ("camera", "origin"):
                value = value[index]
            elif item.name == "around":
                value = None
            picked[item.name] = value
        return ShadePoints(**picked)


def sky_points(d: np.ndarray, trail: np.ndarray | None = None) -> ShadePoints:
    """What a world's nodes see in directions d (n, 3): Cycles makes the direction the position and the coordinates.

    trail : (n,) i64 of the paths that look; the world lies a bounce further, as in Cycles
    """
    d = np.ascontiguousarray(d, np.float32)
    n = len(d)
    return ShadePoints(
        p=d, ng=-d, ns=-d, wo=-d, backfacing=np.zeros(n, bool), uvs=_Everywhere(np.zeros((n, 2), np.float32)),
        generated=d, object=d, normal_local=-d, parametric=np.zeros((n, 2), np.float32),
        trail=None if trail is None else trail + FROM_LIGHT,
        instance=np.zeros(n, np.int32), objects=NO_OBJECT, camera=np.eye(4, dtype=np.float32),
        island_random=np.zeros(n, np.float32), window=(-1.0, 1.0, -1.0, 1.0, 1.0),
        corners=np.zeros((n, 3, 3), np.float32), tangents=_Everywhere(np.zeros((n, 4), np.float32)),
        attributes=_Everywhere(np.zeros((n, 4), np.float32)),
    )  # fmt: skip


class _Everywhere(dict):
    """A dictionary that has one value for every name: a sky has no UVs, tangents or attributes."""

    def __init__(self, value: np.ndarray) -> None:
        super().__init__()
        self._value = value

    def __missing__(self, name: str) -> np.ndarray:
        """The value, whatever the name."""
        return self._value


def probe_points(n: int, needs: frozenset[str] = frozenset()) -> ShadePoints:
    """n harmless points on the plane z = 0 seen from above, filled with all that `needs` names."""
    def rows(*values: float) -> np.ndarray:
        return np.tile(np.array(values, np.float32), (n, 1))

    layers = {name.partition(":")[2]: np.zeros((n, 2), np.float32) for name in needs if name.split(":")[0] == "uv"}
    return ShadePoints(
        p=rows(0, 0, 0), ng=rows(0, 0, 1), ns=rows(0, 0, 1), wo=rows(0, 0, 1), backfacing=np.zeros(n, bool), uvs=layers,
        generated=rows(0, 0, 0), object=rows(0, 0, 0), normal_local=rows(0, 0, 1), parametric=rows(0, 0),
        corners=np.zeros((n, 3, 3), np.float32),
        instance=np.zeros(n, np.int32), objects=NO_OBJECT, camera=np.eye(4, dtype=np.float32),
        island_random=np.zeros(n, np.float32), window=(-1.0, 1.0, -1.0, 1.0, 1.0),
        tangents={name.partition(":")[2]: rows(1, 0, 0, 1) for name in needs if name.split(":")[0] == "tangent"},
        attributes={name.partition(":")[2]: np.zeros((n, 5), np.float32)
                    for name in needs if name.split(":")[0] == "attribute"},
    )  # fmt: skip
