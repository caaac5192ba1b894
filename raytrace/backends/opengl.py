"""The assignment's GLSL on OpenGL: Mesa's llvmpipe, or whatever GPU there is."""

from raytrace.backends.gpu.renderer import GlslRenderer

__all__ = ["Renderer"]


class Renderer(GlslRenderer):
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`."""

    engine = "opengl"
