"""What a graphics engine is asked, and what it answers with when it cannot."""

from dataclasses import dataclass, field

import numpy as np

__all__ = ["ActiveUniform", "Drawing", "ShaderProgram", "ShaderRejected", "Unavailable"]


class Unavailable(Exception):
    """The engine cannot be had, or not for this: the message says what is missing."""


class ShaderRejected(Exception):
    """A shader does not compile or link: the message is the compiler's log."""


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
    """

    program: ShaderProgram
    width: int
    height: int
    first: int
    count: int
    uniforms: dict[str, np.ndarray]
    textures: dict[str, np.ndarray] = field(default_factory=dict)
    passes: tuple[dict[str, np.ndarray], ...] = ({},)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Of the result, float32: pass, row from the bottom up, column, RGBA."""
        return len(self.passes), self.count, self.width, 4

    @property
    def viewport(self) -> tuple[int, int, int, int]:
        """Of the whole image, in a framebuffer of those rows: the quad is always that of the whole image."""
        return 0, -(self.height - self.first - self.count), self.width, self.height
