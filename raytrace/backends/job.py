"""What a backend is asked for, but for the scene's numbers."""

from dataclasses import dataclass
from typing import Any

from raytrace.glsl.source import ShaderSource
from raytrace.language.control import Engine
from raytrace.shader.pixel import Frame
from raytrace.shader.uniforms import Program

__all__ = ["ForeignShader", "Job"]


@dataclass(frozen=True)
class ForeignShader:
    """Somebody's own fragment shader.

    uniforms: pairs of a uniform's name and what it stands for (`raytrace.glsl.matching.matched`).
    time_limit: seconds that it may take.
    """

    source: ShaderSource
    uniforms: tuple[tuple[str, Any], ...] = ()
    time_limit: float = 60.0


@dataclass(frozen=True)
class Job:
    """The choices of one rendering; hashable, so that a compiled program can be kept for it.

    keep: the names of the steps to give back (`raytrace.shader.Steps`).
    dtype: the arithmetic.
    exact_inputs: carry the scene's numbers as they are, instead of rounding each once to float32 before.
    skip: leave out what the scene does not need; without, the same bits take longer.
    engine: instead of the backend's own.
    shader: instead of the scene's program, on the backends that can run one.
    """

    program: Program
    frame: Frame
    keep: tuple[str, ...]
    dtype: str
    exact_inputs: bool = False
    skip: bool = True
    engine: Engine | str | None = None
    shader: ForeignShader | None = None
