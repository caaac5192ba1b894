"""Run time against error: which ways to render are not beaten in both by another."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

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
    """Write the plot, an SVG or a PNG by the file's name: both scales logarithmic, the front drawn, the rest grey.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5.5))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.88, 0.83))
    axes.set_xscale("log")
    axes.set_yscale("log")
    points = [(row, row.errors.rms) for row in rows if row.errors and row.errors.rms > 0]
    best = front([row for row, _ in points])
    axes.plot([row.timing.median for row in best], [rms for row, rms in points if row in best], color="C0", zorder=2)
    for row, rms in points:
        color = "C0" if row in best else "0.6"
        spread = [[row.timing.median - row.timing.fastest], [row.timing.slowest - row.timing.median]]
        axes.errorbar(row.timing.median, rms, xerr=spread, fmt="o", color=color, capsize=2, zorder=3)
    axes.set_xlabel("milliseconds a frame (median; bars: fastest and slowest)")
    axes.set_ylabel("root mean square error of display values,\npixels on a discontinuity left out")
    axes.set_title(title, parse_math=False)
    axes.grid(which="major", color="0.9")
    axes.margins(0.12)
    # What gives no image is a line, whose name stands at it, at the bottom.
    for row in (row for row in rows if row.errors is None):
        axes.axvline(row.timing.median, color="C1", linestyle=":", zorder=1)
        axes.annotate(
            row.name, (row.timing.median, 0.02), xycoords=axes.get_xaxis_transform(), xytext=(2, 0),
            textcoords="offset points", rotation=90, va="bottom", fontsize=7, color="C1",
        )  # fmt: skip
    _name(axes, [(row, rms, "C0" if row in best else "0.45") for row, rms in points])
    save_figure(figure, path, 120)


#: Where a point's name may stand, in points from it, the best place first.
_PLACES = [(7 * side, 11 * up * step) for step in range(18) for up in (-1, 1) for side in (1, -1)]


def _name(axes: Any, points: list[tuple[Row, float, str]]) -> None:
    """Write each row's name beside its point, in its colour, where no other name, point or bar is."""
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    renderer = axes.figure.canvas.get_renderer()
    taken = [text.get_window_extent(renderer) for text in axes.texts]
    for row, rms, _ in points:
        (left, y), (right, _) = axes.transData.transform([(row.timing.fastest, rms), (row.timing.slowest, rms)])
        taken.append(Bbox.from_extents(left - 3, y - 5, right + 3, y + 5))
    for row, rms, color in points:
        for place in _PLACES:
            right, up = place
            # At the bar's end, or above or below the point.
            at = (row.timing.slowest if right > 0 else row.timing.fastest) if up == 0 else row.timing.median
            text = axes.annotate(
                row.name, (at, rms), xytext=(right, up), textcoords="offset points", fontsize=8, color=color,
                va="center", ha="left" if right > 0 else "right", zorder=4,
                arrowprops={"arrowstyle": "-", "color": "0.8", "shrinkB": 3} if up else None,
            )  # fmt: skip
            text.update_positions(renderer)
            box = Text.get_window_extent(text, renderer)  # without the line to the point
            inside = axes.bbox.x0 < box.x0 and box.x1 < axes.bbox.x1 and axes.bbox.y0 < box.y0 and box.y1 < axes.bbox.y1
            # Where there is no room the name stands at the last place all the same.
            if (inside and not any(box.overlaps(other) for other in taken)) or place == _PLACES[-1]:
                taken.append(box.padded(2))
                break
            text.remove()
