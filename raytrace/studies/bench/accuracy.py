"""How far an image is from the exact one, and where that says something."""

from typing import Any, NamedTuple

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import Scene

__all__ = ["Errors", "ExactImage", "reference"]


class Errors(NamedTuple):
    """Of display values, the largest of a pixel's three channels, over the pixels that are on no discontinuity.

    over: pixels that are off by more than 1/255; edge_over: the same of the pixels on a discontinuity.
    """

    largest: float
    rms: float
    percentile_999: float
    percentile_9999: float
    over: int
    edge_over: int


class ExactImage(NamedTuple):
    """The exact image (height, width, 3), and the pixels (height, width) that are on a discontinuity."""

    display: np.ndarray
    edge: np.ndarray
    dtype: str

    def errors(self, image: Any) -> Errors:
        """The errors of an image of the same scene and size."""
        error = np.abs(np.asarray(image) - self.display).max(axis=-1).astype(np.float64)
        over = ~(error <= 1 / 255)  # NaN is over, too
        # A small picture can be all edges: of no pixel there is no error.
        inner = error[~self.edge] if not self.edge.all() else np.full(1, np.nan)
        return Errors(
            float(inner.max()),
            float(np.sqrt((inner**2).mean())),
            float(np.quantile(inner, 0.999)),
            float(np.quantile(inner, 0.9999)),
            int(np.count_nonzero(over & ~self.edge)),
            int(np.count_nonzero(over & self.edge)),
        )


def reference(scene: Scene | str, size: tuple[int, int]) -> ExactImage:
    """NumPy's image in longdouble, where that is wider than float64, and in float64 elsewhere."""
    wider = np.finfo(np.longdouble).eps < np.finfo(np.float64).eps
    dtype = "longdouble" if wider else "float64"
    # The formula for the sphere is the one that does not cancel: it is the nearer one to the real number.
    steps = render(scene, size, backend="numpy", dtype=dtype, output="steps", intersection="robust")
    return ExactImage(steps["display"], discontinuities(steps), dtype)


def discontinuities(steps: dict[str, np.ndarray]) -> np.ndarray:
    """Whether a pixel or one of its eight neighbours sees another thing than it does: the step that lies between them
    lies within the pixel's own reach.

    Another thing is another surface, shadow for light, another colour of a pattern, or the other side of the horizon.
    """
    decisions = np.stack(
        [
            steps["index"],
            steps["shadow"],
            *np.moveaxis(steps["albedo"], -1, 0),
            steps["NdL"] > 0,
            steps["rd"][..., 1] < 0,
        ],
        axis=-1,
    ).astype(np.float64)
    padded = np.pad(decisions, ((1, 1), (1, 1), (0, 0)), mode="edge")
    height, width, _ = decisions.shape
    edge = np.zeros((height, width), bool)
    for dy in range(3):
        for dx in range(3):
            edge |= (padded[dy : dy + height, dx : dx + width] != decisions).any(axis=-1)
    return edge
