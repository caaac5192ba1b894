"""The command `mutants`, for the development of raytrace itself."""

import json
from typing import Annotated

import typer

from raytrace.cli.waits import progress

__all__ = ["mutants"]


def mutants(
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Try which one-line mistakes bounds find, and which metrics.

    The mistakes are in the GLSL, and are drawn on OpenGL; the bounds are certified.

    Exit code 1 if a correct engine is outside the bounds.
    """
    from raytrace.mistakes import MUTATIONS
    from raytrace.studies.mutants import DETECTORS, SCENES, study

    with progress(len(SCENES) + len(MUTATIONS), "rendering") as advance:
        result = study(done=advance)
    if as_json:
        caught = {detector: result.caught(detector) for detector in DETECTORS}
        print(json.dumps(result._asdict() | {"caught": caught}, indent=1))
    else:
        print(
            f"{'mistake: in how many scenes found, of':38} " + " ".join(f"{name:>16}" for name in ("tried", *DETECTORS))
        )
        for name, found in result.found.items():
            counts = (result.tried[name], *(found[detector] or "-" for detector in DETECTORS))
            print(f"{name:38} " + " ".join(f"{count:>16}" for count in counts))
        shares = "".join(f" {f'{result.caught(detector):.0%}':>16}" for detector in DETECTORS)
        print(f"{f'of {len(result.found)} mistakes':38} {'':>16}{shares}")
        limits = "".join(f" {limit:>16.3g}" for limit in result.limits.values())
        print(f"{'threshold (SSIM: 1 - SSIM; PSNR: -dB)':38} {'':>16} {'none':>16}{limits}")
        for alarm in result.false_alarms:
            print(f"false alarm: {alarm}")
    if result.false_alarms:
        raise typer.Exit(1)
