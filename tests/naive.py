"""Kernels written again without any cleverness, in plain numpy: slow, short and plain to see right.

Twins of the gather and the photon grid stand beside those kernels, in their own tests.
"""

import numpy as np


def nearest_hit(corners, o, d, t_max):
    """(triangle or -1, t) nearest along o + t d, by solving v0 + u e1 + v e2 = o + t d for all triangles.

    corners : (T, 3, 3);  o, d : (3,)
    """
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    m = np.stack([e1, e2, np.broadcast_to(-d, e1.shape)], axis=2)
    u, v, t = np.linalg.solve(m, (o - corners[:, 0])[..., None])[..., 0].T
    t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < t_max), t, np.inf)
    i = int(np.argmin(t))
    return (i, t[i]) if np.isfinite(t[i]) else (-1, t_max)


def fresnel(angle, eta):
    """Unpolarised reflectance at an angle of incidence [rad], by Snell's law and Fresnel's sines and tangents.

    eta : index beyond over index here. [Born and Wolf 1999, 1.5.2, eq. 21a]
    """
    if np.sin(angle) >= eta:
        return 1.0
    if angle < 1e-4:
        return ((eta - 1) / (eta + 1)) ** 2
    beyond = np.arcsin(np.sin(angle) / eta)
    s = np.sin(angle - beyond) / np.sin(angle + beyond)
    p = np.tan(angle - beyond) / np.tan(angle + beyond)
    return (s**2 + p**2) / 2


def world_corners(scene):
    """(T, 3, 3) corners of all triangles of all instances, in order."""
    out = []
    for instance in scene.instances:
        mesh = scene.meshes[instance.mesh]
        p = np.c_[mesh.positions, np.ones(len(mesh.positions))] @ instance.matrix.T
        out.append(p[:, :3][mesh.triangles])
    return np.concatenate(out)
