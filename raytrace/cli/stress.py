"""The command `stress`."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from raytrace.cli.waits import progress
from raytrace.errors import InputError

__all__ = ["stress"]


def stress(
    axes: Annotated[list[str] | None, typer.Argument(help="Names of axes, such as distance; default: all.")] = None,
    full: Annotated[bool, typer.Option("--full", help="More cases, more points, larger images.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of all random numbers.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    plot: Annotated[Path | None, typer.Option(help="A folder: also write a figure of each axis there, PNG.")] = None,
) -> None:
    """Hold each formula against exact arithmetic.

    In every arithmetic; exit code 1 if a documented bound does not hold.
    """
    try:
        import flint  # noqa: F401
    except ImportError:
        raise InputError("stress: needs exact arithmetic: pip install python-flint") from None
    from raytrace.studies.stress import AXES, FULL, QUICK, verdicts
    from raytrace.studies.stress import stress as measurements
    from raytrace.studies.stress.plot import plot as write_plot
    from raytrace.studies.stress.running import groups
    from raytrace.studies.stress.spheres import peers

    groups(axes or [])
    if plot and not plot.is_dir():
        raise InputError(f"{plot}: there is no such folder")
    by_axis: dict[str, list] = {}
    with progress(len(axes or AXES), "measuring") as advance:
        for point in measurements((FULL if full else QUICK)._replace(seed=seed), axes):
            if point.axis not in by_axis:
                advance(1)
            by_axis.setdefault(point.axis, []).append(point)
    found = verdicts(point for points in by_axis.values() for point in points)
    missing = peers()[1]
    if as_json:
        points = [point._asdict() for points in by_axis.values() for point in points]
        bounds = [verdict._asdict() | {"holds": verdict.holds} for verdict in found]
        print(json.dumps({"points": points, "bounds": bounds, "missing": missing}, indent=1))
    else:
        for axis, points in by_axis.items():
            print(f"{AXES[axis].title}, by {AXES[axis].x}")
            _print(points)
        _print_bounds(found, missing)
    if plot:
        for axis, points in by_axis.items():
            write_plot(axis, points, plot / f"{axis}.png")
    if not all(verdict.holds for verdict in found):
        raise typer.Exit(1)


def _print(points: list) -> None:
    """A row for each arithmetic and formula: the worst, and where."""
    headings = ("wrong", "at", "ULP", "at", "ULP/condition")
    print(f"  {'the largest':32} " + " ".join(f"{heading:>9}" for heading in headings))
    for who in dict.fromkeys(point.who for point in points):
        mine = [point for point in points if point.who == who]
        cells = [*_largest(mine, "wrong"), *_largest(mine, "ulp"), _largest(mine, "conditioned")[0]]
        print(f"  {who:32} " + " ".join(f"{cell:>9}" for cell in cells).rstrip())
    print()


def _largest(points: list, field: str) -> tuple[str, str]:
    known = [point for point in points if getattr(point, field) is not None]
    if not known:
        return "", ""
    worst = max(known, key=lambda point: getattr(point, field))
    value = getattr(worst, field)
    return f"{value:.3g}", f"{worst.x:.1e}" if value else ""


def _print_bounds(found: list[Any], missing: list[str]) -> None:
    if found:
        print(f"{'bounds':88} {'found':>9} {'at most':>9}")
    for verdict in found:
        failed = "" if verdict.holds else "  does not hold"
        print(f"{verdict.statement:88} {verdict.found:9.3g} {verdict.at_most:9.3g}{failed}")
    for line in missing:
        print(line)
