"""A scene as something that runs elsewhere: GLSL, ShaderLabWeb's GLSL, a web page."""

from raytrace.export.page import html
from raytrace.export.shaders import glsl, shaderlabweb

__all__ = ["EXPORTS"]

#: What a scene can be exported to: functions of the scene and the size, (width, height), that give a file's text.
EXPORTS = {"glsl": glsl, "shaderlabweb": shaderlabweb, "html": html}
