"""Commands that go from images back to scenes: `fit-sun`, and how right derivatives are, `gradients`."""

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import Changes, Layer, Scene, Size, check_outputs, size_of
from raytrace.cli.waits import progress
from raytrace.errors import InputError, check_choice
from raytrace.files import check_figure
from raytrace.scene.toml import DEFAULT_SCENE, load_scene
from raytrace.tables import plain

__all__ = ["fit_sun", "gradients", "sun_trials"]

_FAILED = 1


def fit_sun(
    image: Annotated[Path, typer.Argument(help="A picture of the scene: PNG, EXR, TIFF, JPEG.")],
    scene: Annotated[
        str | None,
        typer.Option(
            "--scene", help="A built-in scene's name or a TOML file; default: the file's own, or checkerboard."
        ),
    ] = None,
    changes: Changes = [],  # noqa: B006 (typer's way)
    kind: Annotated[str | None, typer.Option("--is", help="display or linear; default: what the file says.")] = None,
    exposure: Annotated[bool, typer.Option("--exposure", help="Find the exposure as well.")] = False,
    samples: Annotated[
        int | None, typer.Option(help="n for n x n samples a pixel; default: what the file says, or what explains it.")
    ] = None,
    antialias: Annotated[str | None, typer.Option(help="none, or edges; default: as for --samples.")] = None,
    layer: Layer = None,
    starts: Annotated[int, typer.Option(help="Guesses that are followed at the most, if nearly as likely.")] = 4,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Also write the scene with that sun, TOML.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Also draw the way there, an .svg or .png file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Find the sun's direction in a picture of a scene.

    Exit code 1 if the picture does not tell it.
    """
    from raytrace.inverse.fit import DoesNotFit, NotDetermined, fitted_scene, steps_of
    from raytrace.inverse.fit import fit_sun as fitted
    from raytrace.inverse.picture import scene_seen
    from raytrace.inverse.plot import plot as plot_fit
    from raytrace.scene.toml import save_scene

    if plot:
        check_figure(plot)
    check_outputs([out, plot], [image, scene])
    known = scene_seen(image, scene, changes)
    try:
        with progress(steps_of(starts), "fitting") as advance:
            found = fitted(
                image,
                known,
                kind=kind,
                exposure=exposure,
                starts=starts,
                samples=samples,
                antialias=antialias,
                layer=layer,
                progress=advance,
            )
    except (NotDetermined, DoesNotFit) as error:
        print(f"raytrace: {image}: {error}", file=sys.stderr)
        raise typer.Exit(_FAILED) from None
    if out:
        save_scene(fitted_scene(known, found), out)
    if plot:
        plot_fit(found, plot)
    print(json.dumps(found.to_dict(), indent=1) if as_json else found)


def sun_trials(
    scene: Scene = DEFAULT_SCENE,
    suns: Annotated[int, typer.Option(help="How many random suns.")] = 50,
    size: Size = "192x108",
    samples: Annotated[int, typer.Option(help="n for n x n samples a pixel of the images.")] = 1,
    seed: Annotated[int, typer.Option(help="Of the random suns and of the noise.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Try how near fit-sun comes to random suns.

    From noisy images of 8 bits; and how often its regions hold the sun.
    """
    from raytrace.studies.trials import summary, trials

    if suns < 1:
        raise InputError(f"suns: must be 1 at least, found {suns}")
    if seed < 0:
        raise InputError(f"seed: must be 0 at least, found {seed}")
    known, shape, found = load_scene(scene), size_of(size), []
    with progress(suns, "fitting") as advance:
        for trial in trials(known, suns, shape, samples, seed):
            found.append(trial)
            advance(1)
    print(json.dumps([trial._asdict() for trial in found], indent=1) if as_json else summary(found))


def gradients(
    parameters: Annotated[
        list[str] | None, typer.Option("--parameter", help="A parameter, such as 'sun azimuth'; repeatable.")
    ] = None,
    chosen: Annotated[
        list[str] | None, typer.Option("--world", help="A world, such as 'random-00'; repeatable. Default: all.")
    ] = None,
    finer: Annotated[
        bool, typer.Option("--finer", help="Also edges in 4x4 squares a pixel, which takes longer.")
    ] = False,
    theirs: Annotated[
        Path | None,
        typer.Option(help="Another program's derivatives instead of ours, .npz: 'WORLD/PARAMETER' to an array."),
    ] = None,
    references: Annotated[
        Path | None, typer.Option(help="A folder of worlds and references; default: the package's own.")
    ] = None,
    write: Annotated[
        Path | None, typer.Option(help="Compute the worlds' references and write them to this folder, instead.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Hold the image's derivatives against boundary integrals.

    With edges and without.
    """
    from raytrace.studies.references import STORED, read_benchmark, read_theirs, write_benchmark
    from raytrace.studies.worlds import PARAMETERS, worlds

    for name in parameters or ():
        check_choice("parameter", name, PARAMETERS)
    if write is not None:
        if theirs or references or parameters or finer or as_json:
            raise InputError("write: goes with --world only")
        made = {world.name: world for world in worlds()}
        names = _names_of(made, chosen)
        with progress(sum(len(made[name].parameters) for name in names), "references") as advance:
            write_benchmark(write, [made[name] for name in names], advance)
        print(f"{write}: references of {len(names)} worlds")
        return

    from raytrace.studies.gradients import CHOICES, FINER, Error, errors, misses, our_errors, table

    if theirs is not None and finer:
        raise InputError("finer: is a choice of ours, and goes without --theirs")
    held = {each.world.name: each for each in read_benchmark(references or STORED)}
    blocks = read_theirs(theirs, held.values()) if theirs is not None else None
    names = _names_of(held, chosen)
    asked = [
        (parameter, held[name])
        for parameter in parameters or PARAMETERS
        for name in names
        if parameter in held[name].references and (blocks is None or (name, parameter) in blocks)
    ]
    if not asked:
        raise InputError("gradients: none of those worlds has a derivative by any of those parameters")
    found: dict[str, dict[str, dict[str, Error]]] = {}
    choices = tuple(name for name in CHOICES if finer or name != FINER)
    with progress(len(asked), "differentiating") as advance:
        for parameter, each in asked:
            name = each.world.name
            if blocks is None:
                of = our_errors(each, parameter, choices)
            else:
                of = {"theirs": errors(blocks[name, parameter], each.references[parameter])}
            found.setdefault(parameter, {})[name] = of
            advance(1)
    if as_json:
        print(json.dumps(plain(found), indent=1, allow_nan=False))
        return
    print(table(found))
    out = misses(found)
    if out:
        print("\nout of the limits, in percent:")
        print("\n".join(out))


def _names_of(known: Iterable[str], chosen: list[str] | None) -> list[str]:
    for name in chosen or ():
        check_choice("world", name, known)
    return list(dict.fromkeys(chosen)) if chosen else list(known)
