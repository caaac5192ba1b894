"""A scene's image in real numbers: the shader's own text, run exactly."""

import numpy as np

from raytrace.arithmetic.exact import Exact, precision
from raytrace.language.control import Engine, running
from raytrace.language.tree import tree_map
from raytrace.scene import Scene
from raytrace.scene.to_uniforms import program_of, rounded, uniforms_of
from raytrace.shader.main import Steps
from raytrace.shader.pixel import Frame, pixels

__all__ = ["exact_steps"]

#: Binary digits that tell the decisions of a picture apart.
BITS = 400


def exact_steps(
    scene: Scene,
    size: tuple[int, int],
    keep: tuple[str, ...],
    *,
    shadow_start: str = "offset",
    engine: Engine | None = None,
) -> Steps:
    """The steps named in `keep`, of planes (height, width) or () of `Exact`; the scene's numbers rounded to float32.

    engine: instead of the plain one.

    Raises:
        Undecided: a decision cannot be told with `BITS` digits, as where a ray touches a sphere.
    """
    width, height = size
    with precision(BITS), running(engine or Engine()):
        given = tree_map(Exact.of, rounded(uniforms_of(scene, width / height)))
        row, column = (Exact.of(plane.astype(np.float64)) for plane in np.indices((height, width)))
        return pixels(given, program_of(scene, "textbook", shadow_start), column, row, Frame(width, height), keep)
