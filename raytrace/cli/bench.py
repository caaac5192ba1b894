"""The command `bench`."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from raytrace.cli.options import Size, size_of
from raytrace.cli.waits import progress
from raytrace.errors import InputError, check_choice
from raytrace.files import check_figure
from raytrace.scene.toml import DEFAULT_SCENE
from raytrace.studies.bench.timing import REST, state

__all__ = ["bench"]

#: Of the pictures by which a device's accuracy is checked: all scenes take minutes.
ACCURACY_SIZE = (96, 54)


def bench(
    scene: Annotated[str, typer.Argument(help="A built-in scene's name or a TOML file.")] = DEFAULT_SCENE,
    size: Size = "1920x1080",
    runs: Annotated[int, typer.Option(min=1, help="Frames that are timed, after one that is not.")] = 5,
    rest: Annotated[float, typer.Option(min=0, help="Seconds of rest before each frame.")] = REST,
    scaling: Annotated[str | None, typer.Option(help="Instead: time against spheres, pixels or devices.")] = None,
    figures: Annotated[
        bool, typer.Option("--figures", help="Instead: the ratios and errors to reach; exit code 1 if one is missed.")
    ] = False,
    scenes: Annotated[
        bool, typer.Option("--scenes", help="Instead: each figure of the assignment, by backend.")
    ] = False,
    roofline: Annotated[
        bool, typer.Option("--roofline", help="Instead: operations of the program against this machine's peak.")
    ] = False,
    device: Annotated[
        bool, typer.Option("--device", help="Instead: what JAX's first device takes, programs alone and waited for.")
    ] = False,
    device_accuracy: Annotated[
        bool,
        typer.Option(
            "--device-accuracy", help="Instead: whether it keeps every promise, at 96x54; exit code 1 if not."
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Also write a plot, .svg or .png; of the times, or with --scaling.")
    ] = None,
) -> None:
    """Time every way to render a scene against its error.

    Peers are included; compilation is apart.
    """
    chosen = [
        name
        for name, value in (
            ("--scaling", scaling),
            ("--figures", figures),
            ("--scenes", scenes),
            ("--roofline", roofline),
            ("--device", device),
            ("--device-accuracy", device_accuracy),
        )
        if value
    ]
    if len(chosen) > 1:
        raise InputError(f"{' and '.join(chosen)}: one at a time")
    if (device or device_accuracy) and scene != DEFAULT_SCENE:
        raise InputError(f"{chosen[0]}: draws scenes of its own, not {scene}")
    if plot and (figures or scenes or roofline or device or device_accuracy):
        raise InputError(f"--plot: there is none with {chosen[0]}")
    if plot:
        check_figure(plot)
    shape = size_of(size)
    if not as_json:
        print(state(), flush=True)
    if scaling:
        _scaling(scaling, shape, runs, as_json, plot)
    elif figures:
        _figures(shape, runs, rest, as_json)
    elif scenes:
        _scenes(shape, runs, as_json)
    elif roofline:
        _roofline(scene, shape, runs, as_json)
    elif device:
        _device(shape, runs, as_json)
    elif device_accuracy:
        _device_accuracy(as_json)
    else:
        _pareto(scene, shape, runs, rest, as_json, plot)


def _pareto(scene: str, size: tuple[int, int], runs: int, rest: float, as_json: bool, plot: Path | None) -> None:
    from raytrace.scene import load_scene
    from raytrace.studies.bench import pareto
    from raytrace.studies.bench.contenders import contenders

    loaded = load_scene(scene)
    found, missing = contenders(loaded, size)
    with progress(len(found) * (runs + 1), "timing") as advance:
        rows = pareto.measured(found, loaded, size, runs, lambda name, ms: advance(1), rest)
    best = pareto.front(rows)
    if plot:
        pareto.plot(rows, f"{scene}, {size[0]}x{size[1]}", plot)
    if as_json:
        front = [_json(row) | {"front": row in best} for row in rows]
        print(json.dumps({"state": state(), "rows": front, "missing": missing}, indent=1))
        return
    times, errors = ("median ms", "fastest", "slowest"), ("largest", "rms", "99.99 %", ">1/255", "at edges")
    print(f"{'':36} " + " ".join(f"{heading:>9}" for heading in times + errors))
    for row in rows:
        name = f"{'*' if row in best else ' '} {row.name}"
        print(f"{name:36} {row.timing.median:9.1f} {row.timing.fastest:9.1f} {row.timing.slowest:9.1f}", end="")
        if row.errors:
            e = row.errors
            print(f" {e.largest:9.1e} {e.rms:9.1e} {e.percentile_9999:9.1e} {e.over:9} {e.edge_over:9}", end="")
        print()
    print("* not beaten in both time and rms error by another")
    for line in missing:
        print(line)


def _scaling(kind: str, size: tuple[int, int], runs: int, as_json: bool, plot: Path | None) -> None:
    from raytrace.studies.bench import scaling

    check_choice("--scaling", kind, scaling.KINDS)
    points = []
    if not as_json:
        print(f"{kind:>10}  {'':16} {'median ms':>10} {'fastest':>9} {'slowest':>9} {'once':>9}", flush=True)
    for point in scaling.scaling(kind, size, runs):
        points.append(point)
        if not as_json:
            once = "" if point.preparation is None else f" {point.preparation:9.1f}"
            median, fastest, slowest = point.timing
            print(f"{point.work:10,}  {point.name:16} {median:10.1f} {fastest:9.1f} {slowest:9.1f}{once}", flush=True)
    if as_json:
        print(json.dumps([_json(point) for point in points], indent=1))
    if plot:
        scaling.plot(points, kind, plot)


def _figures(size: tuple[int, int], runs: int, rest: float, as_json: bool) -> None:
    from raytrace.studies.bench.figures import Figure, figures

    found, missing = [], []
    if not as_json:
        print(f"{'':74} {'reached':>9} {'at most':>9}", flush=True)
    for figure in figures(size, runs, rest):
        if not isinstance(figure, Figure):
            missing.append(figure)
            continue
        found.append(figure)
        if not as_json:
            missed = "" if figure.reached <= figure.at_most else "  missed"
            print(
                f"{figure.name:74} {figure.reached:9.3g} {figure.at_most:9.3g}  ({figure.detail}){missed}", flush=True
            )
    if as_json:
        print(
            json.dumps(
                {"state": state(), "figures": [figure._asdict() for figure in found], "missing": missing}, indent=1
            )
        )
    else:
        for line in missing:
            print(line)
    if any(figure.reached > figure.at_most for figure in found):
        raise typer.Exit(1)


def _scenes(size: tuple[int, int], runs: int, as_json: bool) -> None:
    from raytrace.studies.bench.scenes import scene_timings

    rows = []
    if not as_json:
        print(f"{'scene':14} {'how':14} {'median ms':>10} {'fastest':>10} {'slowest':>10}", flush=True)
    for scene, how, timing in scene_timings(size, runs):
        rows.append({"scene": scene, "how": how, **timing._asdict()})
        if not as_json:
            print(
                f"{scene:14} {how:14} {timing.median:10.1f} {timing.fastest:10.1f} {timing.slowest:10.1f}", flush=True
            )
    if as_json:
        print(json.dumps(rows, indent=1))


def _roofline(scene: str, size: tuple[int, int], runs: int, as_json: bool) -> None:
    from raytrace.studies.bench.roofline import roofline

    found = roofline(scene, size, runs)
    if as_json:
        print(json.dumps(found._asdict(), indent=1))
        return
    print(f"operations of a frame, nothing skipped {found.operations / 1e9:10.2f} G (as XLA counts)")
    print(f"bytes that its kernels read and write  {found.bytes / 1e9:10.2f} GB")
    print(f"peak of fused multiply-adds, measured  {found.peak_operations / 1e9:10.1f} GFLOP/s")
    print(f"peak of a copy, measured               {found.peak_bytes / 1e9:10.1f} GB/s")
    print(f"a frame, nothing skipped               {found.milliseconds:10.1f} ms")
    print(f"its operations at that peak            {found.at_least:10.1f} ms, {100 * found.share:.0f} % of it")


def _device(size: tuple[int, int], runs: int, as_json: bool) -> None:
    from raytrace.studies.bench.device import rows

    found = []
    if not as_json:
        print(f"{'':44} {'ms':>10} {'compiling s':>12} {'largest':>9} {'rms':>9} {'>1/255':>7}", flush=True)
    for row in rows(size, runs):
        found.append(row)
        if not as_json:
            e = row.errors
            errors = f" {e.largest:9.1e} {e.rms:9.1e} {e.over:7}" if e else ""
            print(f"{row.name:44} {row.milliseconds:10.4f} {row.compiling:12.1f}{errors}", flush=True)
    print(json.dumps({"state": state(), "device": _device_name(), "rows": [_json(row) for row in found]}))


def _device_accuracy(as_json: bool) -> None:
    from raytrace.studies.bench.device import checks

    found = []
    for check in checks(ACCURACY_SIZE):
        found.append(check)
        if not as_json:
            print(f"{'kept' if check.kept else 'MISSED':6} {check.name}: {check.detail}", flush=True)
    print(json.dumps({"state": state(), "device": _device_name(), "checks": [_json(check) for check in found]}))
    if not all(check.kept for check in found):
        raise typer.Exit(1)


def _device_name() -> str:
    import jax

    return jax.devices()[0].device_kind


def _json(row: Any) -> dict[str, Any]:
    """A named tuple and those within it."""
    return {key: _json(value) if hasattr(value, "_asdict") else value for key, value in row._asdict().items()}
