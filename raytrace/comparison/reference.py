"""What a scene itself says of an image: its steps, and what it would look like through another view."""

from functools import cached_property

import numpy as np

from raytrace.backends.numpy import Masked, drawn
from raytrace.comparison.wrong_views import WrongView
from raytrace.rendering import Options, Rendering
from raytrace.scene import Scene
from raytrace.scene.to_uniforms import program_of, rounded, uniforms_of
from raytrace.shader.pixel import Frame

__all__ = ["Reference"]


class Reference:
    """A scene at the size of an image, rendered by NumPy in float64 when it is first asked."""

    def __init__(self, scene: Scene, width: int, height: int):
        self.scene, self.frame = scene, Frame(width, height)

    @cached_property
    def steps(self) -> dict[str, np.ndarray]:
        """Every step of the shader, by the assignment's names."""
        return Rendering(Options(self.scene, self.frame[:2], backend="numpy", dtype="float64", output="steps")).whole()

    def through(self, view: WrongView, every: int = 1) -> np.ndarray:
        """The display values of the scene, drawn with that mistake in its view; of every so many rows and columns.

        The mistake is in the pixels' coordinates, as a shader has it: half a pixel then gives the very coordinates
        of the pixels' corners, which a horizon may be on.
        """
        uniforms = rounded(uniforms_of(self.scene, self.frame.width / self.frame.height))
        program = program_of(self.scene, "textbook")
        columns, rows = view.pixels(self.frame.width, self.frame.height)
        engine = Masked(uniforms, program)
        return drawn(uniforms, program, columns[::every], rows[::every], self.frame, ("display",), engine)["display"]
