"""What a restructuring must not change: written before it, compared with after each of its steps.

    python -m tests.baseline write FILE.npz
    python -m tests.baseline compare FILE.npz [--only numpy names]

Parts: `numpy` (images and steps, bit for bit), `jax` (the same, to 2 ULP off discontinuities), `bounds` (certificates,
bit for bit), `exits` (exit codes of bad input), `names` (public names and commands with their signatures). The file is
of one machine and one version of the code, and is not committed.
"""

import argparse
import inspect
import re
import sys
import tempfile
from collections.abc import Iterator
from importlib import import_module
from itertools import product
from typing import Any

import numpy as np

import raytrace
from tests.processes import command

SIZE = (64, 36)
#: Scenes whose every choice is a program of JAX's own; the rest have the default choice.
WITH_CHOICES = ("checkerboard", "two-tilted-planes")
CHOICES = ({"samples": 2}, {"antialias": "edges"}, {"shadow_start": "surface"}, {"skip": False})
BAD_INPUT = {
    "tests.test_cli": (),
    "tests.golden.test_golden": (),
    "tests.comparison.test_command": ("compare",),
    "tests.certificates.test_verify": (),
    "tests.studies.stress.test_command": ("stress",),
    "tests.backends.test_devices": ("render",),
}


def numpy_images() -> Iterator[tuple[str, np.ndarray]]:
    """Every step of every scene in every arithmetic and by both formulas, and the images of the other choices."""
    for scene, dtype, intersection in product(
        raytrace.scenes(), ("float32", "float64", "longdouble"), ("textbook", "robust")
    ):
        steps = raytrace.render(scene, SIZE, backend="numpy", dtype=dtype, intersection=intersection, output="steps")
        for name, step in steps.items():
            yield f"{scene}/{dtype}/{intersection}/{name}", step
    for scene, choice in product(raytrace.scenes(), (*CHOICES, {"exact_inputs": True})):
        name = "=".join(map(str, *choice.items()))
        yield f"{scene}/{name}", raytrace.render(scene, SIZE, backend="numpy", dtype="float64", **choice)


def jax_images() -> Iterator[tuple[str, np.ndarray]]:
    """The steps of every scene in both arithmetics, and the images of the other choices for a few of them."""
    for scene, dtype in product(raytrace.scenes(), ("float32", "float64")):
        for name, step in raytrace.render(scene, SIZE, dtype=dtype, output="steps").items():
            yield f"{scene}/{dtype}/{name}", np.asarray(step)
    for scene, choice in product(WITH_CHOICES, CHOICES):
        name = "=".join(map(str, *choice.items()))
        yield f"{scene}/float32/{name}", np.asarray(raytrace.render(scene, SIZE, **choice))


def bounds() -> Iterator[tuple[str, np.ndarray]]:
    """What certificates say of each pixel."""
    for scene, precision in product(raytrace.scenes(), ("real", "glsl-highp")):
        found = raytrace.certify(scene, (32, 18), precision=precision).bounds
        for values in ("display", "linear"):
            for end, array in zip(("low", "high"), getattr(found, values), strict=True):
                yield f"{scene}/{precision}/{values}/{end}", array
        yield f"{scene}/{precision}/reason", found.reason


def exits() -> Iterator[tuple[str, np.ndarray]]:
    """The exit code of each bad input of the tests, in an empty folder."""
    for module, before in BAD_INPUT.items():
        for arguments, _ in import_module(module).BAD_INPUT:
            given = [*before, *arguments]
            with tempfile.TemporaryDirectory() as folder:
                code = command(*given, cwd=folder).returncode
            yield " ".join(given), np.array(code)


def names() -> Iterator[tuple[str, np.ndarray]]:
    """Signatures of the public names, members of the classes among them, and the options of each command."""
    for name in raytrace.__all__:
        value = getattr(raytrace, name)
        yield name, np.array(_signature(value))
        if inspect.isclass(value):
            for member, inner in sorted(vars(value).items()):
                if not member.startswith("_"):
                    yield f"{name}.{member}", np.array(_signature(inner))
    from raytrace.cli.groups import COMMANDS, command

    for name, one in ((name, command(name)) for name in COMMANDS):
        yield f"raytrace {name}", np.array(" ".join(sorted(str(option) for p in one.params for option in p.opts)))


def _signature(value: Any) -> str:
    try:
        return re.sub(r" at 0x[0-9a-f]+", "", str(inspect.signature(value)))
    except (TypeError, ValueError):
        return type(value).__name__


PARTS = {"numpy": numpy_images, "jax": jax_images, "bounds": bounds, "exits": exits, "names": names}


def part(name: str) -> dict[str, np.ndarray]:
    return {f"{name}: {key}": np.asarray(value) for key, value in PARTS[name]()}


def differences(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> list[str]:
    """A line for each key that differs: missing, new, or of another value."""
    found = [f"{key}: missing" for key in before.keys() - after.keys()]
    found += [f"{key}: new" for key in after.keys() - before.keys()]
    for key in before.keys() & after.keys():
        a, b = before[key], after[key]
        if a.shape != b.shape or a.dtype != b.dtype:
            found.append(f"{key}: {a.shape} {a.dtype} became {b.shape} {b.dtype}")
        elif key.startswith("jax: "):
            where = off_discontinuities(key, before, after)
            far = (a != b if a.dtype.kind != "f" else ulps(a, b) > 2).reshape(*where.shape, -1).any(-1) & where
            if far.any():
                found.append(f"{key}: {far.sum()} pixels are over 2 ULP off, by {np.abs(a - b).max():.3g} at most")
        elif not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
            found.append(f"{key}: {a} became {b}" if a.ndim == 0 else f"{key}: {np.sum(a != b)} values differ")
    return sorted(found)


def ulps(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How far numbers are apart, in units in the last place of the larger one."""
    return np.abs(a - b) / np.spacing(np.maximum(np.abs(a), np.abs(b)))


def off_discontinuities(key: str, before: dict, after: dict) -> np.ndarray:
    """Pixels whose surface, pattern and shadow did not change, and those of images that tell of no steps: all."""
    where = np.ones(before[key].shape[:2], bool)
    base, _, _ = key.rpartition("/")
    for step in ("index", "albedo", "shadow"):
        name = f"{base}/{step}"
        if name in before and name in after:
            where &= (before[name] == after[name]).reshape(*where.shape, -1).all(-1)
    return where


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.baseline", description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=["write", "compare"])
    parser.add_argument("file")
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS), help="these parts alone")
    given = parser.parse_args()
    if given.what == "write":
        np.savez_compressed(given.file, **{key: value for name in given.only for key, value in part(name).items()})
        return 0
    with np.load(given.file) as stored:
        before = {key: stored[key] for key in stored.files}
    failed = False
    for name in given.only:
        mine = {key: value for key, value in before.items() if key.startswith(f"{name}: ")}
        found = differences(mine, part(name))
        print(f"{name}: {len(mine)} compared, {len(found)} differ", *found, sep="\n  ", flush=True)
        failed |= bool(found)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
