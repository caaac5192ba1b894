"""The assignment's GLSL on WebGL2 in a browser: Chromium, headless, by Playwright."""

from raytrace.backends.gpu.renderer import GlslRenderer

__all__ = ["Renderer"]


class Renderer(GlslRenderer):
    """A scene, ready to be rendered; see `raytrace.backends.Renderer`."""

    engine = "webgl"
