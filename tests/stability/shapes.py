"""Triangles that are not proper ones: they are left out, named once, and change nothing else."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, case, same_randoms, shoot, told
from .space import reference
from .transforms import plain, with_mesh

# all inside the room, so that neither its box nor its middle moves
POINT = np.zeros((3, 3))
LINE = np.array([[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.2, 0.0, 0.5]])


def _ignored(name: str, positions, message: str = "", short: bool = False) -> None:
    @case("triangles", name, "the rest of the picture, bit for bit" + (", and a message" if message else ""), short)
    def check() -> Finding:
        count = len(positions) // 3
        mesh = s.mesh(positions, np.arange(3 * count).reshape(count, 3))
        shot = shoot(with_mesh(plain(), mesh))
        found = same_randoms(reference(), shot)
        gap = float(np.abs(shot.mean() - reference().mean()).max())
        heard = not message or (told(shot, "Odd", message) and len(shot.issues) == 1)
        said = ", told" if message and heard else ""
        return Finding(gap == 0.0 and heard, f"differs by {gap:g}{said}", found.seconds)


_ignored("all corners in one point", POINT, short=True)
_ignored("corners on a line", LINE)
_ignored("a corner that is NaN", np.array([[0, 0, 0], [0.1, 0, 0], [0, np.nan, 0]]), "not a finite number", short=True)
_ignored("a corner at infinity", np.array([[0, 0, 0], [0.1, 0, 0], [0, np.inf, 0]]), "not a finite number")
_ignored("a corner at 1e38", np.array([[0, 0, 0], [0.1, 0, 0], [0, 3e38, 0]]) * [1, 10, 1], "not a finite number")


@case("triangles", "an empty mesh", "the rest of the picture, bit for bit", short=True)
def empty() -> Finding:
    mesh = s.mesh(np.zeros((0, 3)), np.zeros((0, 3), int))
    shot = shoot(with_mesh(plain(), mesh))
    gap = float(np.abs(shot.mean() - reference().mean()).max())
    return Finding(gap == 0.0, f"differs by {gap:g}", shot.seconds)


@case("triangles", "an object of scale 0", "the rest of the picture, bit for bit", short=True)
def no_scale() -> Finding:
    matrix = np.diag([0.0, 0.0, 0.0, 1.0])
    shot = shoot(with_mesh(plain(), s.sphere((0, 0, 0), 0.2), matrix=matrix))
    gap = float(np.abs(shot.mean() - reference().mean()).max())
    return Finding(gap == 0.0, f"differs by {gap:g}", shot.seconds)


def _sliced(x: np.ndarray):
    """The back wall of the room in vertical slices that end at x, ascending from -1 to 1."""
    scene = plain()
    bottom = np.stack([x, np.ones_like(x), -np.ones_like(x)], 1)
    i = np.arange(len(x) - 1)
    n = len(x)
    triangles = np.concatenate([np.stack([i, i + 1, n + i + 1], 1), np.stack([i, n + i + 1, n + i], 1)])
    scene.meshes[_back(scene)] = s.mesh(np.concatenate([bottom, bottom + np.array([0.0, 0.0, 2.0])]), triangles)
    return scene


def _back(scene) -> int:
    """Number of the back wall."""
    return [item.name.startswith("back") for item in scene.instances].index(True)


@case("triangles", "a wall of 1e6 needles, 1e6:1", "same picture")
def needles() -> Finding:
    return same_randoms(reference(), shoot(_sliced(np.linspace(-1.0, 1.0, 1_000_001))), allowed=0.02)


@case("triangles", "sizes of 1e7:1 in one object", "same picture", short=True)
def sizes_in_one() -> Finding:
    """The back wall in tiles that shrink toward its middle from 1 m to 0.1 micrometres."""
    scene = plain()
    half = 10.0 ** np.linspace(0.0, -7.0, 36)
    ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    flat = (half[:, None, None] * ring).reshape(-1, 2)
    points = np.stack([flat[:, 0], np.ones(len(flat)), flat[:, 1]], 1)
    k, j = np.meshgrid(4 * np.arange(35), np.arange(4), indexing="ij")
    a, b = (k + j).ravel(), (k + (j + 1) % 4).ravel()
    middle = [[140, 141, 142], [140, 142, 143]]
    triangles = np.concatenate([np.stack([a, b, b + 4], 1), np.stack([a, b + 4, a + 4], 1), middle])
    scene.meshes[_back(scene)] = s.mesh(points, triangles)
    return same_randoms(reference(), shoot(scene), allowed=0.02)


@case("triangles", "sizes of 1e7:1 in two objects", "same picture", short=True)
def sizes_in_two() -> Finding:
    """The room, balls of triangles of 5 cm in it, in the middle of a black box of 1000 km."""
    box = s.box((-5e5, -5e5, -5e5), (5e5, 5e5, 5e5), inward=True)
    return same_randoms(reference(), shoot(with_mesh(plain(), box, s.diffuse(0.0))), allowed=0.02)


@case("triangles", "edges of three and four faces", "as the same faces apart", short=True)
def not_manifold() -> Finding:
    """Fins that stand on the edge of a box, sharing its corners; apart, each face has corners of its own."""
    box = s.box((-0.5, -0.2, -0.9), (0.1, 0.4, -0.4))
    top = np.flatnonzero(box.positions[:, 2] > -0.5)
    edge = top[np.lexsort(box.positions[top].T)][:2]
    points = np.concatenate([box.positions, box.positions[edge] + (0, 0, 0.3), box.positions[edge] + (-0.3, 0.1, 0.2)])
    n = len(box.positions)
    fins = [[edge[0], edge[1], n + 1], [edge[0], n + 1, n], [edge[0], edge[1], n + 3], [edge[0], n + 3, n + 2]]
    joined = np.concatenate([box.triangles, fins])
    apart = s.mesh(points[joined].reshape(-1, 3), np.arange(3 * len(joined)).reshape(-1, 3))
    for color in (s.diffuse(0.5), s.glass(1.5)):
        found = same_randoms(*(shoot(with_mesh(plain(), m, color)) for m in (apart, s.mesh(points, joined))))
        if not found.good:
            break
    return found


@case("triangles", "every triangle of a wall twice", "same picture")
def twice() -> Finding:
    scene = plain()
    mesh = scene.meshes[_back(scene)]
    mesh.triangles = np.concatenate([mesh.triangles, mesh.triangles])
    return same_randoms(reference(), shoot(scene), allowed=0.02)


@case("triangles", "a wall and its reverse in one place", "same picture")
def coincident() -> Finding:
    scene = plain()
    mesh = scene.meshes[_back(scene)]
    mesh.triangles = np.concatenate([mesh.triangles, mesh.triangles[:, ::-1]])
    return same_randoms(reference(), shoot(scene), allowed=0.02)


@case("triangles", "walls mirrored by a negative scale", "same picture")
def mirrored() -> Finding:
    scene = plain()
    for mesh, item in zip(scene.meshes, scene.instances, strict=True):
        mesh.positions = mesh.positions * np.float32([-1, 1, 1])
        if mesh.normals is not None:
            mesh.normals = mesh.normals * np.float32([-1, 1, 1])
        mesh.triangles = mesh.triangles[:, [0, 2, 1]]
        if mesh.normals is not None:
            mesh.normals = mesh.normals[:, [0, 2, 1]]
        item.matrix = np.diag([-1.0, 1.0, 1.0, 1.0])
    return same_randoms(reference(), shoot(scene), allowed=0.02)


@case("triangles", "a mesh sheared by its object, 1e4:1", "same picture as the sheared mesh itself")
def sheared() -> Finding:
    shear = np.eye(4)
    shear[0, 2] = 1e4
    ball = s.sphere((0, 0, 0), 0.3)
    flat = s.mesh(ball.positions @ np.linalg.inv(shear)[:3, :3].T, ball.triangles)
    straight = shoot(with_mesh(plain(), s.sphere((0, 0, 0), 0.3, smooth=False)))
    return same_randoms(straight, shoot(with_mesh(plain(), flat, matrix=shear)), allowed=0.02)
