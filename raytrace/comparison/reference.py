"""What a scene itself says of an image: its steps, and what it would look like through another view."""

from functools import cached_property

import numpy as np

from raytrace.backends.numpy import TILE, Masked
from raytrace.comparison.views import View
from raytrace.edges import pixels
from raytrace.language.control import running
from raytrace.language.tree import tree_map
from raytrace.rendering import Rendering
from raytrace.scene import Scene
from raytrace.scene.uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame

__all__ = ["Reference"]


class Reference:
    """A scene at the size of an image, rendered by NumPy in float64 when it is first asked."""

    def __init__(self, scene: Scene, width: int, height: int):
        self.scene, self.frame = scene, Frame(width, height)

    @cached_property
    def steps(self) -> dict[str, np.ndarray]:
        """Every step of the shader, by the assignment's names."""
        return Rendering(self.scene, self.frame[:2], backend="numpy", dtype="float64", output="steps").whole()

    def through(self, view: View, every: int = 1) -> np.ndarray:
        """The display values of the scene, drawn with that mistake in its view; of every so many rows and columns.

        The mistake is in the pixels' coordinates, as a shader has it: half a pixel then gives the very coordinates
        of the pixels' corners, which a horizon may be on.
        """
        uniforms = uniforms_of(self.scene, self.frame.width / self.frame.height)
        uniforms = tree_map(lambda x: np.asarray(x, np.float32).astype(np.float64), uniforms)
        program = program_of(self.scene, "textbook")
        columns, rows = view.pixels(self.frame.width, self.frame.height)
        columns, rows = columns[::every], rows[::every]
        image = np.empty((len(rows), len(columns), 3))
        size, engine = max(1, TILE**2 // len(columns)), Masked(uniforms, program)
        for first in range(0, len(rows), size):
            part = slice(first, first + size)
            column, row = np.meshgrid(columns, rows[part])
            with running(engine), np.errstate(all="ignore"):
                steps = pixels(uniforms, program, column, row, self.frame, ("display",))
            for channel, plane in enumerate(steps.display):
                image[part, :, channel] = plane
        return image
