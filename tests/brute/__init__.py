"""A small, slow and independent renderer that the engine is tested against.

It shares only the scene records with the engine: its own intersection, scattering, lights, camera and random numbers.
``render`` traces paths from the eye, ``trace_light`` paths from the lights; both sort what they find by Heckbert's
classes, so each pass of the engine has its own expected picture.

Restricted on purpose: constant colours; Lambert, translucent, mirror, smooth glass and refraction, transparent,
emission, and constant mixtures of these. Anything else raises a RenderError rather than render something else.
"""

from .light_tracer import trace_light
from .path_tracer import render

__all__ = ["render", "trace_light"]
