"""WebGL2 in a browser: Chromium, headless, by Playwright; SwiftShader where there is no GPU."""

import base64
import os
import shutil
from importlib import resources
from typing import Any

import numpy as np

from raytrace.backends.gpu.drawing import ActiveUniform, Drawing, ShaderProgram, ShaderRejected, Unavailable

__all__ = ["WebGL", "chromium"]

#: The names that Chromium's command has.
_COMMANDS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_FLAGS = (
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
)
#: Pixels of one reading: the answer is a text, and a browser's texts have limits.
_READING = 1 << 22


def chromium(playwright: Any) -> Any:
    """The browser, started by a running Playwright.

    Raises:
        Unavailable: Chromium is not installed, or does not start.
    """
    command = next(filter(None, map(shutil.which, _COMMANDS)), None)
    if command is None:
        raise Unavailable("needs Chromium: apt-get install chromium")
    try:
        # Chromium refuses to run as root with its sandbox, and Playwright leaves it out unless it is asked for.
        root = getattr(os, "geteuid", lambda: 1)() == 0
        return playwright.chromium.launch(executable_path=command, args=list(_FLAGS), chromium_sandbox=not root)
    except Exception as error:
        reason = " ".join(str(error).split())[:200]
        raise Unavailable(
            f"needs Chromium, and {command} does not start (apt-get install chromium): {reason}"
        ) from None


class WebGL:
    """A page in a browser, with a WebGL2 context and the programs compiled on it."""

    def __init__(self) -> None:
        try:
            from playwright.sync_api import sync_playwright
        except ImportError:
            raise Unavailable("needs Playwright: pip install playwright") from None
        self._playwright = sync_playwright().start()
        try:
            self._browser = chromium(self._playwright)
        except Unavailable:
            self._playwright.stop()  # or it could not be started again
            raise
        self._page = self._browser.new_page()
        self._page.set_default_timeout(0)
        script = resources.files("raytrace.backends.gpu") / "webgl.js"
        self._page.add_script_tag(content=script.read_text(encoding="utf-8"))
        self._ask("start")

    def about(self) -> str:
        """The real renderer: its name, the version of WebGL, the browser's."""
        return f"{self._ask('about')}; Chromium {self._browser.version}"

    def active_uniforms(self, program: ShaderProgram) -> list[ActiveUniform]:
        """The uniforms that the program uses."""
        return [
            ActiveUniform(name, _type(constant), length)
            for name, constant, length in self._ask("activeUniforms", _program(program))
        ]

    def draw(self, drawing: Drawing, out: np.ndarray) -> None:
        """Draws into `out`, an array of `drawing.shape`."""
        request = {
            "program": _program(drawing.program),
            "width": drawing.width,
            "height": drawing.height,
            "uniforms": _uniforms(drawing.uniforms),
            "textures": [(name, _texture(texels)) for name, texels in drawing.textures.items()],
            "passes": [_uniforms(changed) for changed in drawing.passes],
            "alpha": drawing.alpha,
        }
        x, y, *size = drawing.viewport
        rows = max(1, _READING // drawing.width)
        for bottom in range(0, drawing.count, rows):
            band = out[:, bottom : bottom + rows]
            left, below, *box = drawing.box
            part = {"count": band.shape[1], "viewport": [x, y - bottom, *size], "box": [left, below - bottom, *box]}
            for image, text in zip(band, self._ask("draw", request | part)["images"], strict=True):
                image[...] = np.frombuffer(base64.b64decode(text), np.float32).reshape(image.shape)

    def close(self) -> None:
        """Ends the browser."""
        self._browser.close()
        self._playwright.stop()

    def _ask(self, method: str, argument: Any = None) -> Any:
        """The page's answer.

        Raises:
            ShaderRejected: a shader does not compile.
            Unavailable: the browser cannot do this.
            RuntimeError: the context was lost, as when the driver crashed.
        """
        answer = self._page.evaluate("([method, argument]) => answer(method, argument)", [method, argument])["result"]
        if isinstance(answer, dict):
            if "rejected" in answer:
                raise ShaderRejected(answer["rejected"], answer["stage"])
            if "unavailable" in answer:
                raise Unavailable(answer["unavailable"])
            if "lost" in answer:
                raise RuntimeError("the context was lost")
        return answer


def _program(program: ShaderProgram) -> dict[str, str]:
    return {"vertex": program.vertex, "fragment": program.fragment}


def _type(constant: str) -> str:
    """``vec3`` for FLOAT_VEC3."""
    if constant == "SAMPLER_2D":
        return "sampler2D"
    if constant == "UNSIGNED_INT":
        return "uint"
    if "_" not in constant:
        return constant.lower()
    scalar, kind = constant.lower().split("_", 1)
    return {"float": "", "int": "i", "bool": "b"}.get(scalar, "") + kind


def _uniforms(uniforms: dict[str, np.ndarray]) -> list[tuple[str, list]]:
    """Pairs, as an object of JavaScript has names of its own."""
    return [(name, np.ravel(value).tolist()) for name, value in uniforms.items()]


def _texture(texels: np.ndarray) -> dict[str, Any]:
    height, width, _ = texels.shape
    return {"width": width, "height": height, "texels": base64.b64encode(np.float32(texels).tobytes()).decode()}
