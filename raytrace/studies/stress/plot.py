"""A figure for each axis: the share of wrong decisions, and the largest error, both scales logarithmic."""

from pathlib import Path
from typing import Any

from raytrace.files import save_figure
from raytrace.studies.stress.axes import AXES
from raytrace.studies.stress.measure import INPUT, Measurement

__all__ = ["figure", "plot"]

#: Colours tell the formula apart, or the start of shadow rays; lines the arithmetic; markers who computes.
_COLORS = {"textbook": "C3", "robust": "C0", "offset": "C3", "surface": "C0", "mitsuba": "C2", "embree": "C1"}
_MAPPERS = {"aces": "C0", "reinhard": "C1", "hable": "C2", "none": "C4"}
_MARKERS = {"numpy": "o", "jax": "x", "exact,": "s", "mitsuba": "^", "embree": "v"}


def plot(axis: str, points: list[Measurement], path: Path) -> None:
    """Writes the figure of one axis.

    Raises:
        InputError: the file cannot be written.
    """
    save_figure(figure(axis, points), path)


def figure(axis: str, points: list[Measurement]) -> Any:
    """The figure of one axis, a `matplotlib.figure.Figure`."""
    from matplotlib.figure import Figure

    panels = [
        (field, label)
        for field, label in (
            ("wrong", f"share of cases: {AXES[axis].decision}"),
            ("ulp", "largest error where the decision is right, ULP"),
        )
        if any(getattr(point, field) is not None for point in points)
    ]
    # No wrong case is drawn at the bottom, as a logarithm has no 0; an error of 0 is not drawn.
    none = 1 / (3 * max(point.n for point in points))
    drawn = Figure(figsize=(2 + 4.2 * len(panels), 4.6), layout="constrained")
    for axes, (field, label) in zip(drawn.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for who in dict.fromkeys(point.who for point in points):
            line = [(point.x, getattr(point, field)) for point in points if point.who == who]
            known = [(x, y or none) for x, y in line if y is not None and (y > 0 or field == "wrong")]
            if known:
                axes.plot(*zip(*known, strict=True), label=who, **_style(who))
        axes.set_xlabel(AXES[axis].x)
        axes.set_ylabel(label)
        if field == "wrong":
            axes.axhline(none, color="0.6", lw=0.8, zorder=0)
            axes.annotate(
                "none", (0.01, none), xycoords=("axes fraction", "data"), va="bottom", fontsize=7, color="0.4"
            )
        axes.grid(which="major", color="0.92")
    handles = drawn.axes[0].get_legend_handles_labels()
    drawn.legend(*handles, loc="outside right upper", fontsize=7.5, frameon=False)
    drawn.suptitle(AXES[axis].title)
    return drawn


def _style(who: str) -> dict:
    words = who.split()
    wide = "float64" in who
    if who.startswith(INPUT):
        return {"color": "0.6", "ls": ":" if wide else "-", "lw": 1, "zorder": 1}
    colors = _COLORS | _MAPPERS
    color = next((colors[word] for word in words if word in colors), "C0")
    marker = _MARKERS[words[0]]
    return {"color": color, "ls": ":" if wide else "-", "lw": 1.2, "marker": marker, "ms": 4, "mfc": "none"}
