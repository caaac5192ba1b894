"""Run time against error: which ways to render are not beaten in both by another."""

from collections.abc import Callable
from math import log10
from pathlib import Path
from typing import NamedTuple

from raytrace.bench.contenders import Contender
from raytrace.bench.errors import Errors, reference
from raytrace.bench.timing import Timing, in_turn
from raytrace.files import whole_file
from raytrace.scene.data import Scene

__all__ = ["Row", "front", "measured", "plot"]


class Row(NamedTuple):
    """One way to render; without errors where it gives no image."""

    name: str
    timing: Timing
    errors: Errors | None


def measured(
    contenders: list[Contender],
    scene: Scene | str,
    size: tuple[int, int],
    runs: int,
    done: Callable[[str, float], None] = lambda name, ms: None,
) -> list[Row]:
    """Times and errors of the contenders for a scene, the fastest first; `done` is told of each frame."""
    timings = in_turn({contender.name: contender.frame for contender in contenders}, runs, done)
    exact = reference(scene, size)
    rows = [
        Row(contender.name, timings[contender.name], exact.errors(contender.frame()) if contender.image else None)
        for contender in contenders
    ]
    return sorted(rows, key=lambda row: row.timing.median)


def front(rows: list[Row]) -> list[Row]:
    """The rows, fastest first, that no other beats in both time and root mean square error."""
    best, kept = float("inf"), []
    for row in sorted((row for row in rows if row.errors), key=lambda row: (row.timing.median, row.errors.rms)):
        if row.errors.rms < best:
            best = row.errors.rms
            kept.append(row)
    return kept


def plot(rows: list[Row], title: str, path: Path) -> None:
    """Writes the plot, an SVG or a PNG by the file's name: both scales logarithmic, the front drawn, the rest grey.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 5.5), layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    drawn = [row for row in rows if row.errors and row.errors.rms > 0]
    best = [row for row in front(rows) if row in drawn]
    axes.plot([row.timing.median for row in best], [row.errors.rms for row in best], color="C0", zorder=2)
    for row in drawn:
        leads = row in best
        color = "C0" if leads else "0.6"
        spread = [[row.timing.median - row.timing.fastest], [row.timing.slowest - row.timing.median]]
        axes.errorbar(row.timing.median, row.errors.rms, xerr=spread, fmt="o", color=color, capsize=2, zorder=3)
    _label(axes, drawn, best)
    for row in rows:
        if row.errors is None:
            axes.axvline(row.timing.median, color="C1", linestyle=":", zorder=1)
            axes.annotate(
                row.name, (row.timing.median, 0.03), xycoords=("data", "axes fraction"), rotation=90,
                ha="right", fontsize=8, color="C1",
            )  # fmt: skip
    axes.set_xlabel("milliseconds a frame (median; bars: fastest and slowest)")
    axes.set_ylabel("root mean square error of display values,\npixels on a discontinuity left out")
    axes.set_title(title)
    axes.grid(which="major", color="0.9")
    axes.margins(0.12)
    with whole_file(path) as temporary:
        figure.savefig(temporary, format=path.suffix[1:], dpi=120)


def _label(axes: object, drawn: list[Row], best: list[Row]) -> None:
    """Each point's name, moved up or down where it would stand on another's."""
    placed: list[tuple[float, float]] = []
    for row in sorted(drawn, key=lambda row: (row.errors.rms, row.timing.median)):
        x, y = log10(row.timing.median), log10(row.errors.rms)
        offset = 4
        while any(abs(x - other) < 0.45 and abs(y + offset / 60 - height) < 0.16 for other, height in placed):
            offset += 9
        placed.append((x, y + offset / 60))
        axes.annotate(
            row.name, (row.timing.median, row.errors.rms), xytext=(5, offset), textcoords="offset points",
            fontsize=7.5, color="C0" if row in best else "0.4",
        )  # fmt: skip
