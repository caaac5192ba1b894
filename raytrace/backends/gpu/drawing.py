"""What a graphics engine is asked, and what it answers with when it cannot."""

from dataclasses import dataclass, field

import numpy as np

__all__ = ["CORNERS", "ActiveUniform", "Drawing", "ShaderProgram", "ShaderRejected", "Unavailable"]


#: The four vertices of the picture's strip of triangles, as GLSL ES 1.00's attribute ``corner``.
CORNERS = np.array([(0, 0), (1, 0), (0, 1), (1, 1)], np.float32)


class Unavailable(Exception):
    """The engine cannot be had, or not for this: the message says what is missing."""


class ShaderRejected(Exception):
    """A shader does not compile or link: the message is the compiler's log.

    stage: which: "vertex", "fragment", or "link" for both together.
    """

    def __init__(self, log: str, stage: str = "fragment"):
        super().__init__(log)
        self.stage = stage


@dataclass(frozen=True)
class ShaderProgram:
    """The sources of a vertex and a fragment shader."""

    vertex: str
    fragment: str


@dataclass(frozen=True)
class ActiveUniform:
    """A uniform that a compiled program uses: its GLSL name and type; `length` elements if it is an array."""

    name: str
    type: str
    length: int = 1


@dataclass(frozen=True)
class Drawing:
    """Rows of an image, drawn once for each of `passes`.

    width, height: of the whole image.
    first, count: the rows that are drawn; row 0 is on top.
    uniforms: flat arrays by GLSL name, of the uniform's own type; those that the program does not use are left out.
    textures: float32 arrays (height, width, 4) by the sampler's name.
    passes: what is changed in `uniforms` for each pass.
    alpha: of pixels that the shader does not write; their colour is black.
    only: the one pixel (column, row) that is drawn; row 0 is on top.
    """

    program: ShaderProgram
    width: int
    height: int
    first: int
    count: int
    uniforms: dict[str, np.ndarray]
    textures: dict[str, np.ndarray] = field(default_factory=dict)
    passes: tuple[dict[str, np.ndarray], ...] = ({},)
    alpha: float = 0.0
    only: tuple[int, int] | None = None

    @property
    def box(self) -> tuple[int, int, int, int]:
        """Of the framebuffer, what is drawn: x, y from below, width, height."""
        if self.only is None:
            return 0, 0, self.width, self.count
        column, row = self.only
        return column, self.first + self.count - 1 - row, 1, 1

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Of the result, float32: pass, row from the bottom up, column, RGBA."""
        return len(self.passes), self.count, self.width, 4

    @property
    def viewport(self) -> tuple[int, int, int, int]:
        """Of the whole image, in a framebuffer of those rows: the quad is always that of the whole image."""
        return 0, -(self.height - self.first - self.count), self.width, self.height
