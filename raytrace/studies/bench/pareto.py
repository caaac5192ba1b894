"""Run time against error: which ways to render are not beaten in both by another."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from raytrace.files import save_figure
from raytrace.scene.data import Scene
from raytrace.studies.bench.accuracy import Errors, reference
from raytrace.studies.bench.contenders import Contender
from raytrace.studies.bench.timing import REST, Timing, in_turn

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
    rest: float = REST,
) -> list[Row]:
    """Return the contenders' times and errors for a scene, the fastest first; `done` and `rest` as `in_turn` has it."""
    timings = in_turn({contender.name: contender.frame for contender in contenders}, runs, done, rest)
    exact = reference(scene, size)
    rows = [
        Row(one.name, timings[one.name], exact.errors(one.image(one.frame())) if one.image else None)
        for one in contenders
    ]
    return sorted(rows, key=lambda row: row.timing.median)


def front(rows: list[Row]) -> list[Row]:
    """The rows, fastest first, that no other beats in both time and root mean square error."""
    best, kept = float("inf"), []
    with_errors = [(row.timing.median, row.errors.rms, row) for row in rows if row.errors]
    for _, rms, row in sorted(with_errors, key=lambda point: point[:2]):
        if rms < best:
            best = rms
            kept.append(row)
    return kept


def plot(rows: list[Row], title: str, path: Path) -> None:
    """Writes the plot, an SVG or a PNG by the file's name: both scales logarithmic, the front drawn, the rest grey.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5.5), layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    points = [(row, row.errors.rms) for row in rows if row.errors and row.errors.rms > 0]
    best = front([row for row, _ in points])
    axes.plot([row.timing.median for row in best], [rms for row, rms in points if row in best], color="C0", zorder=2)
    for number, (row, rms) in enumerate(points, start=1):
        color = "C0" if row in best else "0.6"
        spread = [[row.timing.median - row.timing.fastest], [row.timing.slowest - row.timing.median]]
        point = row.timing.median, rms
        label = f"{number}  {row.name}"
        axes.errorbar(*point, xerr=spread, fmt="o", color=color, capsize=2, zorder=3, label=label)
        # Neighbours in time have their numbers on different sides.
        below = number % 2 == 0
        offset = (0, -7) if below else (0, 5)
        alignment = {"ha": "center", "va": "top" if below else "bottom", "fontsize": 8, "color": color}
        axes.annotate(str(number), point, xytext=offset, textcoords="offset points", **alignment)
    for row in rows:
        if row.errors is None:
            axes.axvline(row.timing.median, color="C1", linestyle=":", zorder=1, label=row.name)
    axes.set_xlabel("milliseconds a frame (median; bars: fastest and slowest)")
    axes.set_ylabel("root mean square error of display values,\npixels on a discontinuity left out")
    axes.set_title(title, parse_math=False)
    axes.grid(which="major", color="0.9")
    axes.margins(0.08)
    figure.legend(loc="outside right upper", fontsize=8, frameon=False, handlelength=1.2)
    save_figure(figure, path, 120)
