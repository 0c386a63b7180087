"""Volume shaders: what they absorb [1/m]; light that they scatter or give is reported and left out."""

from __future__ import annotations

import numpy as np

from ...bsdf import layout, recipes
from ..registry import column, node


def absorbing(sigma):
    """A volume that takes exp(-sigma) of light for each metre."""
    return recipes.make(layout.ABSORPTION, sigma)


@node("ShaderNodeVolumeAbsorption")
def absorption(x, props, points):
    """Everything but the colour, by density."""
    return {"Volume": absorbing(np.maximum(1.0 - x["Color"], 0.0) * column(np.maximum(x["Density"], 0.0)))}


@node("ShaderNodeVolumePrincipled")
def principled_volume(x, props, points):
    """The absorbing part: what neither scatters nor has the square root of the absorption colour."""
    taken = np.maximum(1.0 - x["Color"], 0.0) * np.maximum(1.0 - np.sqrt(np.maximum(x["Absorption Color"], 0.0)), 0.0)
    return {"Volume": absorbing(taken * column(np.maximum(x["Density"], 0.0)))}


@node("ShaderNodeVolumeCoefficients")
def coefficients(x, props, points):
    """The absorption coefficients."""
    return {"Volume": absorbing(np.maximum(x["Absorption Coefficients"], 0.0))}


@node("ShaderNodeVolumeScatter")
def scatter(x, props, points):
    """Nothing: scattering is not simulated."""
    return {"Volume": []}
