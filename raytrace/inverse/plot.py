"""The way that a fit of the sun took, drawn."""

from pathlib import Path
from typing import Any

import numpy as np

from raytrace.files import save_figure
from raytrace.inverse.fit import SunFit

__all__ = ["figure", "plot"]


def plot(fit: SunFit, path: Path) -> None:
    """Writes the figure, an SVG or a PNG by the file's name.

    Raises:
        InputError: the file cannot be written.
    """
    save_figure(figure(fit), path)


def figure(fit: SunFit) -> Any:
    """A `matplotlib.figure.Figure`: the loss of each start by step, and its sun's way over the sky, seen from below."""
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(10, 4.2), layout="constrained")
    losses = drawn.add_subplot(1, 2, 1)
    sky = drawn.add_subplot(1, 2, 2, projection="polar")
    for number, course in enumerate(fit.history):
        color = f"C{number}"
        losses.semilogy(course.loss, color=color, label="the best start" if number == 0 else f"start {number + 1}")
        turn = np.radians(course.azimuth)
        sky.plot(turn, 90 - course.elevation, color=color)
        sky.plot(turn[:1], 90 - course.elevation[:1], "o", color=color, markersize=4)
    sky.plot([np.radians(fit.azimuth)], [90 - fit.elevation], "*", color="black", markersize=12)
    losses.set_xlabel("step")
    losses.set_ylabel("mean squared difference of display values")
    losses.legend(frameon=False)
    sky.set_ylim(0, 90)
    sky.set_yticks([30, 60, 90], ["60°", "30°", "0°"])
    sky.set_title("azimuth, and elevation from the rim (0°)", fontsize=10)
    return drawn
