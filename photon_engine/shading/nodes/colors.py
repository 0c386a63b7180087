"""Nodes on colours: RGB, Mix, Invert, Gamma, Bright/Contrast, Hue/Saturation, separate and combine."""

from __future__ import annotations

import numpy as np

from ..registry import LUMINANCE, constant, f32, node
from .color_spaces import hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv
from .scalars import divide, power

ONE = f32(1.0)


def lerp(t, a, b):
    """(1 - t) a + t b."""
    return (ONE - t) * a + t * b


def overlay(t, a, b):
    """Multiply dark, screen light."""
    low = a * ((ONE - t) + 2.0 * t * b)
    return np.where(a < 0.5, low, ONE - ((ONE - t) + 2.0 * t * (ONE - b)) * (ONE - a))


def dodge(t, a, b):
    """Brighten a by dividing by the inverse of b."""
    rest = ONE - t * b
    return np.where(a == 0.0, a, np.where(rest <= 0.0, ONE, np.minimum(divide(a, rest), ONE)))


def burn(t, a, b):
    """Darken a by dividing its inverse by b."""
    rest = (ONE - t) + t * b
    return np.where(rest <= 0.0, f32(0.0), np.clip(ONE - divide(ONE - a, rest), 0.0, 1.0))


def soft_light(t, a, b):
    """Blender's soft light."""
    screen = ONE - (ONE - b) * (ONE - a)
    return (ONE - t) * a + t * ((ONE - a) * b * a + a * screen)


def hue(t, a, b):
    """A with b's hue."""
    target, own = rgb_to_hsv(b), rgb_to_hsv(a)
    own, target = np.broadcast_arrays(own, target)
    mixed = lerp(t, a, hsv_to_rgb(np.stack([target[0], own[1], own[2]])))
    return np.where(target[1] != 0.0, mixed, a)


def saturation(t, a, b):
    """A with its saturation mixed with b's."""
    own, target = rgb_to_hsv(a), rgb_to_hsv(b)
    mixed = lerp(t, own[1], target[1])
    return np.where(own[1] != 0.0, hsv_to_rgb(np.stack(np.broadcast_arrays(own[0], mixed, own[2]))), a)


def value(t, a, b):
    """A with its value mixed with b's."""
    own, target = rgb_to_hsv(a), rgb_to_hsv(b)
    mixed = lerp(t, own[2], target[2])
    return hsv_to_rgb(np.stack(np.broadcast_arrays(own[0], own[1], mixed)))


def color(t, a, b):
    """A with b's hue and saturation."""
    own, target = np.broadcast_arrays(rgb_to_hsv(a), rgb_to_hsv(b))
    mixed = lerp(t, a, hsv_to_rgb(np.stack([target[0], target[1], own[2]])))
    return np.where(target[1] != 0.0, mixed, a)


# t (n | 1,) or (3, n | 1), a and b (3, n | 1)
BLEND = {
    "MIX": lerp,
    "DARKEN": lambda t, a, b: lerp(t, a, np.minimum(a, b)),
    "MULTIPLY": lambda t, a, b: a * ((ONE - t) + t * b),
    "BURN": burn,
    "LIGHTEN": lambda t, a, b: lerp(t, a, np.maximum(a, b)),
    "SCREEN": lambda t, a, b: ONE - ((ONE - t) + t * (ONE - b)) * (ONE - a),
    "DODGE": dodge,
    "ADD": lambda t, a, b: a + t * b,
    "OVERLAY": overlay,
    "SOFT_LIGHT": soft_light,
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2.0 * b - ONE),
    "DIFFERENCE": lambda t, a, b: lerp(t, a, np.abs(a - b)),
    "EXCLUSION": lambda t, a, b: np.maximum(lerp(t, a, a + b - 2.0 * a * b), 0.0),
    "SUBTRACT": lambda t, a, b: a - t * b,
    "DIVIDE": lambda t, a, b: np.where(b != 0.0, (ONE - t) * a + t * divide(a, b), a),
    "HUE": hue,
    "SATURATION": saturation,
    "COLOR": color,
    "VALUE": value,
}


@node("ShaderNodeRGB")
def rgb(x, props, points):
    """A colour."""
    return {"Color": constant(props.get("value", (0.5, 0.5, 0.5)), "RGBA")}


@node("ShaderNodeMix")
def mix(x, props, points):
    """Mix numbers, vectors or colours."""
    kind = props.get("data_type", "FLOAT")
    clamped = props.get("clamp_factor", True)
    t = x["Factor_Vector"] if kind == "VECTOR" and props.get("factor_mode") == "NON_UNIFORM" else x["Factor_Float"]
    if clamped:
        t = np.clip(t, 0.0, 1.0)
    if kind == "FLOAT":
        return {"Result_Float": lerp(t, x["A_Float"], x["B_Float"])}
    if kind == "VECTOR":
        return {"Result_Vector": lerp(t, x["A_Vector"], x["B_Vector"])}
    result = BLEND[props.get("blend_type", "MIX")](t, x["A_Color"], x["B_Color"])
    return {"Result_Color": np.clip(result, 0.0, 1.0) if props.get("clamp_result") else result}


@node("ShaderNodeMixRGB")
def mix_rgb(x, props, points):
    """The Mix node of old files."""
    t = np.clip(x["Fac"], 0.0, 1.0)
    result = BLEND[props.get("blend_type", "MIX")](t, x["Color1"], x["Color2"])
    return {"Color": np.clip(result, 0.0, 1.0) if props.get("use_clamp") else result}


@node("ShaderNodeInvert")
def invert(x, props, points):
    """1 - colour, mixed by the factor."""
    t = x["Fac"]
    return {"Color": t * (ONE - x["Color"]) + (ONE - t) * x["Color"]}


@node("ShaderNodeGamma")
def gamma(x, props, points):
    """colour^gamma for positive channels."""
    c, g = x["Color"], x["Gamma"]
    raised = power(np.maximum(c, 0.0), g)
    return {"Color": np.where(g == 0.0, ONE, np.where(c > 0.0, raised, c))}


@node("ShaderNodeBrightContrast")
def bright_contrast(x, props, points):
    """(1 + contrast) colour + bright - contrast / 2, not below 0."""
    contrast = x["Contrast"]
    return {"Color": np.maximum((ONE + contrast) * x["Color"] + (x["Bright"] - contrast * f32(0.5)), 0.0)}


@node("ShaderNodeHueSaturation")
def hue_saturation(x, props, points):
    """Turn the hue, scale saturation and value."""
    c = x["Color"]
    hsv = rgb_to_hsv(c)
    h = hsv[0] + x["Hue"] + f32(0.5)
    parts = np.broadcast_arrays(h - np.floor(h), np.clip(hsv[1] * x["Saturation"], 0.0, 1.0), hsv[2] * x["Value"])
    return {"Color": np.maximum(lerp(x["Fac"], c, hsv_to_rgb(np.stack(parts))), 0.0)}


@node("ShaderNodeRGBToBW")
def rgb_to_bw(x, props, points):
    """Luminance."""
    return {"Val": LUMINANCE @ x["Color"]}


TO_RGB = {"HSV": hsv_to_rgb, "HSL": hsl_to_rgb}
FROM_RGB = {"HSV": rgb_to_hsv, "HSL": rgb_to_hsl}


@node("ShaderNodeSeparateColor")
def separate_color(x, props, points):
    """Channels of a colour in RGB, HSV or HSL."""
    c = FROM_RGB.get(props.get("mode", "RGB"), lambda v: v)(x["Color"])
    return {"Red": c[0], "Green": c[1], "Blue": c[2]}


@node("ShaderNodeCombineColor")
def combine_color(x, props, points):
    """A colour from channels in RGB, HSV or HSL."""
    c = np.stack(np.broadcast_arrays(x["Red"], x["Green"], x["Blue"]))
    return {"Color": TO_RGB.get(props.get("mode", "RGB"), lambda v: v)(c)}


@node("ShaderNodeSeparateRGB", "ShaderNodeSeparateHSV")
def separate_old(x, props, points):
    """The separate nodes of old files."""
    if "Image" in x:
        return dict(zip("RGB", x["Image"], strict=True))
    return dict(zip("HSV", rgb_to_hsv(x["Color"]), strict=True))


@node("ShaderNodeCombineRGB", "ShaderNodeCombineHSV")
def combine_old(x, props, points):
    """The combine nodes of old files."""
    if "R" in x:
        return {"Image": np.stack(np.broadcast_arrays(x["R"], x["G"], x["B"]))}
    return {"Color": hsv_to_rgb(np.stack(np.broadcast_arrays(x["H"], x["S"], x["V"])))}
