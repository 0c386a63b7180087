"""Colours of spectra: Blackbody and Wavelength."""

from __future__ import annotations

import numpy as np

from ...bsdf.observer import OBSERVER, XYZ_TO_RGB
from ..registry import f32, node
from .curves import lookup

# red and green of a black body are a / t + b t + c, blue is ((a t + b) t + c) t + d, linear Rec. 709 at luminance 1,
# between these temperatures [K]: the fit that Blender uses
STARTS = (965.0, 1167.0, 1449.0, 1902.0, 3315.0, 6365.0)
RED = np.array([
    [1619.19106, -0.00205010916, 5.02995757],
    [2488.45471, -0.00111330907, 3.22621544],
    [3341.43193, -0.000486551192, 1.76486769],
    [4094.61742, -0.000127446582, 0.725731635],
    [4670.28036, 2.91258199e-05, 0.126703442],
    [4595.09185, 2.87495649e-05, 0.15034502],
    [3787.1745, 9.35907826e-06, 0.399075871],
])
GREEN = np.array([
    [-488.999748, 0.000604330754, -0.0755807526],
    [-755.994277, 0.000316730098, 0.478306139],
    [-1023.63977, 0.00012022347, 0.936662319],
    [-1265.71316, 4.87340896e-06, 1.27054498],
    [-1425.29332, -4.01150431e-05, 1.43972784],
    [-1175.54822, -2.16378048e-05, 1.30408023],
    [-500.799571, -4.59832026e-06, 1.09098763],
])
BLUE = np.array([
    [5.96945309e-11, -4.85742887e-08, -9.70622247e-05, -0.00407936148],
    [2.40430366e-11, 5.55021075e-08, -0.000198503712, 0.0289312858],
    [-1.40949732e-11, 1.89878968e-07, -0.000356632824, 0.0910767778],
    [-3.61460868e-11, 2.84822009e-07, -0.000493211319, 0.15672344],
    [-1.97075738e-11, 1.75359352e-07, -0.000250542825, -0.0222783266],
    [-1.61997957e-13, -1.64216008e-08, 0.000386216271, -0.738077418],
    [6.72650283e-13, -2.73078809e-08, 0.000424098264, -0.752335691],
])
COLDEST, HOTTEST = 800.0, 12000.0
COLD = (5.413294490189271, -0.20319390035873933, -0.0822535242887164)
HOT = (0.8262954810464208, 0.9945080501520986, 1.566307710274283)
BRIGHTEST = 2.52  # of any channel of any wavelength, about


def blackbody_color(t):
    """Linear Rec. 709 (3, n) of a black body at t (n,) kelvin, luminance 1; may be negative."""
    t = t.astype(np.float64)
    inside = np.clip(t, COLDEST, HOTTEST)
    k = np.searchsorted(STARTS, inside, side="right")
    ramps = [table[k, 0] / inside + table[k, 1] * inside + table[k, 2] for table in (RED, GREEN)]
    blue = ((BLUE[k, 0] * inside + BLUE[k, 1]) * inside + BLUE[k, 2]) * inside + BLUE[k, 3]
    color = np.stack([*ramps, blue])
    color = np.where(t < COLDEST, np.array(COLD)[:, None], color)
    return np.where(t >= HOTTEST, np.array(HOT)[:, None], color)


@node("ShaderNodeBlackbody")
def blackbody(x, props, points):
    """The colour of a glowing body."""
    return {"Color": np.maximum(blackbody_color(x["Temperature"]), 0.0).astype(f32)}


@node("ShaderNodeWavelength")
def wavelength(x, props, points):
    """The colour of light of one wavelength [nm]; black outside 380 to 780 nm."""
    place = (x["Wavelength"] - f32(380.0)) * f32(1.0 / 400.0)
    xyz = lookup(OBSERVER.astype(f32), place)
    color = np.maximum(XYZ_TO_RGB.astype(f32) @ xyz, 0.0) * f32(1.0 / BRIGHTEST)
    return {"Color": np.where((place > -0.0125) & (place < 1.0), color, f32(0.0))}
