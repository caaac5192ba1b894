"""All axes, or some of them."""

from collections.abc import Callable, Iterator

from raytrace.errors import check_choice
from raytrace.studies.stress.axes import AXES, GROUPS
from raytrace.studies.stress.effort import QUICK, Effort
from raytrace.studies.stress.measure import Measurement

__all__ = ["groups", "stress"]


def groups(names: list[str]) -> list[Callable]:
    """The groups that hold the axes of those names; all for none.

    Raises:
        InputError: there is no such axis.
    """
    for name in names:
        check_choice("axis", name, AXES)
    return [group for group, axes in GROUPS.items() if not names or set(axes) & set(names)]


def stress(effort: Effort = QUICK, names: list[str] | None = None) -> Iterator[Measurement]:
    """Every measurement of the axes named, or of all.

    Raises:
        InputError: there is no such axis.
    """
    names = list(names or [])
    for group in groups(names):
        for axis, run in _runs(group, effort):
            if not names or axis in names or axis is None:
                yield from (point for point in run() if not names or point.axis in names)


def _runs(group: Callable, effort: Effort) -> Iterator[tuple[str | None, Callable]]:
    """Each function of a group with its axis; ``None`` where one function gives several."""
    runs = list(group(effort))
    axes = GROUPS[group] if len(runs) == len(GROUPS[group]) else [None] * len(runs)
    return zip(axes, runs, strict=True)
