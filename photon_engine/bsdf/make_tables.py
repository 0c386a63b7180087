"""Write tables.npz: directional albedos of GGX by quadrature.  python -m photon_engine.bsdf.make_tables

The grids are those of Blender's renderer, so that interpolation between their points errs alike; the numbers are
integrated here. One row is another: for glass of index 1 it is the limit from above, where facets still mask what
goes straight through them. Blender has 1 there, and its rough glass of an index below 1.009 is up to 17% dark.
Print the checksum and put it into tables.py.
"""

from __future__ import annotations

import hashlib
import math
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from ..jit import kernel
from .fresnel import fresnel_dielectric, schlick_share
from .microfacet import ggx_lambda, sample_vndf
from .observer import FILM_POINTS, FILM_STEP, OBSERVER, XYZ_TO_RGB

MODE_WHITE = 0  # E of a perfectly reflecting GGX
MODE_GLASS = 1  # E of dielectric reflection and refraction together
MODE_SHARE = 2  # mean share between F0 and F90 that the dielectric curve gives
MODE_SCHLICK = 3  # the same for Schlick's (1 - c)^5

POINTS = 32768  # of the quadrature; the largest change from half of them is printed
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
N_FINE = 32
N_COARSE = 16


@kernel
def facet_value(wo, h, eta, alpha2, mode):
    """Integrand of one facet normal: the weight of what leaves, given density of visible normals."""
    c = wo[0] * h[0] + wo[2] * h[2]
    fresnel, cos_t = fresnel_dielectric(c, eta)
    up = 2.0 * c * h[2] - wo[2]
    lambda_o = ggx_lambda(wo[2], alpha2)
    value = 0.0
    if up > 0.0:
        if mode == 2:
            return schlick_share(fresnel, eta)
        if mode == 3:
            return (1.0 - c) ** 5
        value = (1.0 + lambda_o) / (1.0 + lambda_o + ggx_lambda(up, alpha2))
        if mode == 0:
            return value
        value *= fresnel
    if mode == 1 and fresnel < 1.0:
        down = (c / eta - cos_t) * h[2] - wo[2] / eta
        if down < 0.0 or eta < 1.0:  # Blender's table keeps what a tilted facet bends back up, its sampler does not
            value += (1.0 - fresnel) * (1.0 + lambda_o) / (1.0 + lambda_o + ggx_lambda(down, alpha2))
    return value


@kernel
def directional(rough, mu, eta, mode, points):
    """Mean of `facet_value` over visible normals, on a golden-ratio lattice of the two random numbers."""
    alpha = rough * rough
    wo = (math.sqrt(1.0 - mu * mu), 0.0, mu)
    n = (0.0, 0.0, 1.0)
    total = 0.0
    for i in range(points):
        u1 = 0.5 * ((i * GOLDEN) % 1.0)  # half a turn: the other half mirrors it
        h = sample_vndf(wo, n, alpha, u1, (i + 0.5) / points)
        total += facet_value(wo, h, eta, alpha * alpha, mode)
    return total / points


@kernel
def fill(out, rough, mu, eta, mode, points):
    """Directional values into out[z, mu, rough]."""
    for z in range(eta.shape[0]):
        for y in range(mu.shape[0]):
            for x in range(rough.shape[0]):
                out[z, y, x] = directional(rough[x], mu[y], eta[z], mode, points)


def grid(size: int, top: float = 1.0) -> np.ndarray:
    """`size` even steps over [0, 1], the ends moved off the singular values."""
    return np.clip(np.linspace(0.0, 1.0, size), 1e-4, top)


def index_grid(size: int) -> np.ndarray:
    """Indices of refraction at even steps of z = F0^(1/4)."""
    root = grid(size, 0.99) ** 2  # sqrt(F0)
    root = np.minimum(root, math.sqrt(0.99))
    return (1.0 + root) / (1.0 - root)


def tabulate(mode: int, size: int, eta: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Table (len(eta), size, size) over (mu, roughness) and its mean over 2 mu dmu, (len(eta), size)."""
    rough = grid(size)
    table = np.zeros((len(eta), size, size))
    fill(table, rough, grid(size), eta, mode, points)
    nodes, weights = np.polynomial.legendre.leggauss(32)
    mu = 0.5 * (nodes + 1.0)
    dense = np.zeros((len(eta), 32, size))
    fill(dense, rough, mu, eta, mode, points // 2)
    return table, np.einsum("zyx,y->zx", dense, weights * mu)


def film_sensitivity() -> np.ndarray:
    """Fourier transforms of the eye's linear Rec. 709 curves over frequency: (real and imaginary r, g, b; difference).

        S_c(d) = int c(l) exp(-2 pi i d / l) dl / int c(l) dl      [Belcour and Barla 2017, section 4]

    d : optical path difference [nm], FILM_POINTS steps of FILM_STEP;  out : (6, FILM_POINTS)
    """
    measured = np.arange(380.0, 780.1, 5.0)
    wavelength = np.arange(380.0, 780.1, 1.0)
    curves = XYZ_TO_RGB @ CubicSpline(measured, OBSERVER)(wavelength).T
    phase = -2.0 * math.pi * FILM_STEP * np.arange(FILM_POINTS)[:, None] / wavelength
    waves = curves @ np.exp(1j * phase).T / curves.sum(axis=1)[:, None]
    return np.concatenate([waves.real, waves.imag])


def compute(points: int) -> dict[str, np.ndarray]:
    """All tables, float32."""
    eta = index_grid(N_COARSE)
    one = np.ones(1)
    white, white_avg = tabulate(MODE_WHITE, N_FINE, one, points)
    glass, glass_avg = tabulate(MODE_GLASS, N_COARSE, eta, points)
    inverse, inverse_avg = tabulate(MODE_GLASS, N_COARSE, 1.0 / eta, points)
    share, _ = tabulate(MODE_SHARE, N_COARSE, eta, points)
    schlick, _ = tabulate(MODE_SCHLICK, N_COARSE, one, points)
    tables = {
        "white": white, "white_avg": white_avg, "glass": glass, "glass_avg": glass_avg,
        "inverse": inverse, "inverse_avg": inverse_avg, "share": share, "schlick": schlick,
    }  # fmt: skip
    clipped = {name: np.clip(value, 0.0, 1.0).astype(np.float32) for name, value in tables.items()}
    return {**clipped, "film": film_sensitivity().astype(np.float32)}


def main() -> None:
    """Write the file; say its checksum and how far the quadrature has converged."""
    tables = compute(POINTS)
    coarse = compute(POINTS // 2)
    for name, value in tables.items():
        change = np.abs(value - coarse[name]).max()
        sys.stdout.write(f"{name}: {value.shape}, change from half the points {change:.1e}\n")
    path = Path(__file__).with_name("tables.npz")
    with path.open("wb") as file:
        np.savez(file, **tables)
    sys.stdout.write(f"sha256 {hashlib.sha256(path.read_bytes()).hexdigest()}\n")


if __name__ == "__main__":
    main()
