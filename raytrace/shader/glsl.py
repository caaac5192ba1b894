"""GLSL's vocabulary, for those who write a tone mapper: that of `raytrace.language.glsl`."""

from raytrace.language.glsl import *  # noqa: F403
from raytrace.language.glsl import __all__ as __all__
