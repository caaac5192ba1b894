"""Bounds that make a comparison a check."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from raytrace.errors import InputError, check_choice, unknown

if TYPE_CHECKING:
    from raytrace.comparison.result import Comparison

__all__ = ["BOUNDS", "REQUIRED", "Bound", "failures", "requirements"]


class Bound(NamedTuple):
    """What is bounded, and whether from below; `value` is ``None`` where it is undefined."""

    what: str
    least: bool
    value: Callable[["Comparison"], float | None]


BOUNDS = {
    "min_ssim": Bound("SSIM", True, lambda c: c.ssim and c.ssim.mean),
    "min_worst_ssim": Bound("SSIM of the worst window", True, lambda c: c.ssim and c.ssim.worst),
    "min_psnr": Bound("PSNR", True, lambda c: c.psnr),
    "max_rmse": Bound("RMSE", False, lambda c: c.rmse),
    "max_difference": Bound("largest difference", False, lambda c: c.largest.value),
    "max_share": Bound("share of pixels over 1/255", False, lambda c: c.share),
    "max_delta_e": Bound("CIEDE2000, mean", False, lambda c: c.delta_e.mean),
    "max_delta_e_999": Bound("CIEDE2000, 99.9 %", False, lambda c: c.delta_e.p999),
    "max_flip": Bound("FLIP, mean", False, lambda c: c.flip.mean),
    "max_flip_999": Bound("FLIP, 99.9 %", False, lambda c: c.flip.p999),
}


#: The metrics as a requirement names them, and whose bound each one is: ``ssim`` is that of ``min_ssim``.
REQUIRED = {name.partition("_")[2].replace("_", "-"): name for name in BOUNDS}

_REQUIREMENT = re.compile(r"\s*([\w-]+)\s*(>=|<=)\s*(\S+)\s*")


def requirements(texts: Iterable[str]) -> dict[str, float]:
    """Return bounds by the names of `BOUNDS` that texts such as ``"ssim>=0.9999"`` or ``"flip-999<=0.1"`` require.

    Raises:
        InputError: a text has another form, a metric is unknown or needs the other sign, or a bound is not a number.
    """
    bounds = {}
    for text in texts:
        match = _REQUIREMENT.fullmatch(text)
        if match is None:
            raise InputError(f"require: must be like 'ssim>=0.9999' or 'rmse<=0.001', found {text!r}")
        metric, sign, limit = match[1].replace("_", "-").lower(), match[2], match[3]
        if metric not in REQUIRED:
            raise InputError(f"require: {text}: {unknown(metric, REQUIRED)}")
        name = REQUIRED[metric]
        right = ">=" if BOUNDS[name].least else "<="
        if sign != right:
            raise InputError(f"require: {text}: {metric} is bounded by {right}")
        try:
            bounds[name] = float(limit)
        except ValueError:
            raise InputError(f"require: {text}: {limit!r} is not a number") from None
    return bounds


def failures(comparison: "Comparison", bounds: Mapping[str, float | int]) -> list[str]:
    """What `comparison` fails of `bounds`, which are by the names of `BOUNDS`; empty if nothing.

    What is undefined or NaN fails every bound, and a bound that is NaN is failed by everything.

    Raises:
        InputError: there is no such bound.
    """
    failed = []
    for name, limit in bounds.items():
        check_choice("bound", name, BOUNDS)
        what, least, value = BOUNDS[name]
        found = value(comparison)
        # Not `found < limit`: that is False of NaN.
        if found is None or not (found >= limit if least else found <= limit):
            shown = "undefined" if found is None else f"{found:.6g}"
            failed.append(f"{what} is {shown}, must be at {'least' if least else 'most'} {limit:g}")
    return failed
