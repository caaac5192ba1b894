"""A scene as something for elsewhere: GLSL, ShaderLabWeb's GLSL, a web page, constants of C and WGSL."""

from raytrace.export.constants import c_header, wgsl_constants
from raytrace.export.page import html
from raytrace.export.shaders import glsl, shaderlabweb

__all__ = ["EXPORTS"]

#: What a scene can be exported to: functions of the scene and the size, (width, height), that give a file's text.
EXPORTS = {
    "glsl": glsl,
    "shaderlabweb": shaderlabweb,
    "html": html,
    "header": c_header,
    "wgsl-constants": wgsl_constants,
}
