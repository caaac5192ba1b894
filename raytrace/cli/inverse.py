"""Commands that go from images back to scenes: `fit-sun`, and how right derivatives are, `gradients`."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from raytrace.cli.options import Changes, Layer, Scene, Size, check_outputs, progress, size_of
from raytrace.errors import InputError, check_choice
from raytrace.files import check_figure
from raytrace.scene.toml import DEFAULT_SCENE, load_scene

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
    """The direction of the sun in a picture of a scene; exit code 1 if the picture does not tell it."""
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
    """How near fit-sun comes to random suns, from noisy images of 8 bits, and how often its regions hold them."""
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
    worlds: Annotated[int, typer.Option(help="How many random worlds.")] = 20,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """How right the image's derivatives are, with and without edges, against differences of supersampled images."""
    from raytrace.studies.gradients import PARAMETERS, Error, errors, random_world, table

    names = parameters or list(PARAMETERS)
    for name in names:
        check_choice("parameter", name, PARAMETERS)
    if worlds < 1:
        raise InputError(f"worlds: must be 1 at least, found {worlds}")
    found: dict[str, list[dict[str, Error]]] = {name: [] for name in names}
    with progress(len(names) * worlds, "differentiating") as advance:
        for name in names:
            for seed in range(worlds):
                found[name].append(errors(random_world(seed), name))
                advance(1)
    if as_json:
        tables = {name: [{k: e._asdict() for k, e in of.items()} for of in each] for name, each in found.items()}
        print(json.dumps(tables, indent=1))
    else:
        print(table(found))
