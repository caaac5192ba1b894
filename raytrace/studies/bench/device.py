"""What JAX's first device takes: the programs alone, in flight, and what a caller waits for; each with its error.

`checks` holds the promises made elsewhere for a CPU against the device.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from raytrace.rendering import render
from raytrace.scene.data import Scene
from raytrace.scene.toml import DEFAULT_SCENE, load_scene, scenes
from raytrace.studies.bench.accuracy import Errors, reference
from raytrace.studies.bench.crowds import crowd
from raytrace.studies.bench.timing import in_turn, ready

__all__ = ["Check", "DeviceRow", "checks", "rows"]

#: So many pictures are asked for before the first is waited for.
IN_FLIGHT = 100
#: Spheres of the crowds, and a batch of small pictures: its number and its side.
CROWDS = (1000, 100_000, 1_000_000)
BATCH, SIDE = 4096, 64


class DeviceRow(NamedTuple):
    """What was drawn, milliseconds (the median of the runs), seconds to compile it, and the error where it is known."""

    name: str
    milliseconds: float
    compiling: float
    errors: Errors | None = None


class Check(NamedTuple):
    """A promise, whether it is kept, and by how much."""

    name: str
    kept: bool
    detail: str


def rows(
    size: tuple[int, int], runs: int, crowds: Sequence[int] = CROWDS, batch: int = BATCH, in_flight: int = IN_FLIGHT
) -> Iterator[DeviceRow]:
    """Yield the rows, each when it is measured. size: of every picture but those of the batch."""
    import jax
    import jax.numpy as jnp

    scene = load_scene(DEFAULT_SCENE)
    exact = reference(scene, size)
    sun = jnp.asarray(scene.sun.direction, jnp.float32)

    def alone(name: str, picture: Callable, first: Any, image: bool = False, number: int = in_flight) -> DeviceRow:
        """`picture` of so many slightly different suns, asked for together."""
        given = [first + 1e-3 * k * jnp.array([1, 0, 0], first.dtype) for k in range(number)]
        start = time.perf_counter()
        program = jax.jit(picture)
        drawn = jax.block_until_ready(program(given[0]))
        compiling = time.perf_counter() - start

        def all_of_them() -> None:
            jax.block_until_ready([program(one) for one in given])

        milliseconds = _median(all_of_them, runs) / number
        return DeviceRow(name, milliseconds, compiling, exact.errors(drawn) if image else None)

    def waited(name: str, function: Callable, image: bool = False) -> DeviceRow:
        start = time.perf_counter()
        drawn = ready(function())
        compiling = time.perf_counter() - start
        return DeviceRow(name, _median(function, runs), compiling, exact.errors(drawn) if image else None)

    def display(**choices: Any) -> Callable:
        return lambda sun: render(scene.with_("sun.direction", sun), size, **choices)

    yield alone("default scene, the program alone", display(), sun, True)
    yield alone("the same, skipping nothing", display(skip=False), sun, True)
    yield alone("the same by XLA's fusion", display(engine="fused"), sun, True)
    yield waited("the same through render, waiting", lambda: render(scene, size), True)
    yield alone("16 samples a pixel", display(samples=4), sun, number=max(1, in_flight // 5))
    with jax.enable_x64(True):
        row = alone("float64, the program alone", display(dtype="float64"), sun.astype("float64"), True)
    yield row
    yield waited("8 bits on the host", lambda: np.asarray(_eight_bits(render(scene, size))))
    yield waited("float32 on the host", lambda: np.asarray(render(scene, size)), True)

    def brightness(size: tuple[int, int], **choices: Any) -> Callable:
        return lambda sun: jnp.mean(render(scene.with_("sun.direction", sun), size, **choices) ** 2)

    yield alone("value and gradient by the sun", jax.value_and_grad(brightness(size)), sun)
    suns = sun + 1e-4 * jnp.arange(batch)[:, None] * jnp.array([0, 0, 1])
    small = (SIDE, SIDE)
    few = max(1, in_flight // 10)
    several = f"{batch} suns at {SIDE}x{SIDE}"
    yield alone(several, jax.vmap(lambda sun: render(scene.with_("sun.direction", sun), small)), suns, number=few)
    yield alone(f"{several}, value and gradient", jax.vmap(jax.value_and_grad(brightness(small))), suns, number=few)
    for number in crowds:
        many = crowd(number)

        def of_crowd(sun: Any, many: Scene = many) -> Any:
            return render(many.with_("sun.direction", sun), size)

        yield alone(f"{number} spheres, grids included", of_crowd, sun, number=few)
    yield alone("edges", display(antialias="edges"), sun, number=max(1, in_flight // 30))


def _median(function: Callable[[], Any], runs: int) -> float:
    """Milliseconds of a run, after one that does not count."""
    return in_turn({"": function}, runs)[""].median


def _eight_bits(image: Any) -> Any:
    import jax.numpy as jnp

    return jnp.rint(255 * image).astype(jnp.uint8)


def checks(size: tuple[int, int], names: Sequence[str] | None = None) -> Iterator[Check]:
    """Yield the promises for each built-in scene, or those `names`, and whether the device keeps them.

    Its picture lies in the bounds that GLSL's highp leaves; skipping changes no bit; in float64 it is NumPy's to 1e-9;
    derivatives by the sun are the CPU's to 1 %, one by one and in a batch; none is NaN.
    """
    for name in scenes() if names is None else names:
        yield from _checks_of(name, load_scene(name), size)


def _checks_of(name: str, scene: Scene, size: tuple[int, int]) -> Iterator[Check]:
    import jax
    import jax.numpy as jnp

    from raytrace.certificates import certify, verify

    image = np.asarray(render(scene, size, intersection="textbook"))
    verified = verify(image, certify(scene, size, precision="glsl-highp"))
    outside = int((verified.by > 0).sum())
    yield Check(f"{name}: in the bounds of glsl-highp", outside == 0, f"{outside} pixels outside")

    whole = np.asarray(render(scene, size, intersection="textbook", skip=False))
    changed = int((whole != image).any(axis=-1).sum())
    yield Check(f"{name}: skipping changes no bit", changed == 0, f"{changed} pixels")

    exact = reference(scene, size)
    errors = exact.errors(render(scene, size, dtype="float64"))
    yield Check(f"{name}: float64 is NumPy's", errors.largest < 1e-9, f"largest difference {errors.largest:.1e}")

    weights = np.random.default_rng(0).normal(size=(size[1], size[0], 3)).astype("float32")
    suns = np.asarray(scene.sun.direction, "float32") + np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.3, 0.1]], "float32")

    def weighted(sun: Any) -> Any:
        return jnp.sum(render(scene.with_("sun.direction", sun), size, output="linear") * weights)

    slope = jax.jit(jax.grad(weighted))
    here = np.array([slope(sun) for sun in suns])
    together = np.asarray(jax.jit(jax.vmap(jax.grad(weighted)))(suns))
    pairs = [("derivatives in a batch are each picture's", together, here)]
    if jax.devices()[0].platform != "cpu":
        with jax.default_device(jax.devices("cpu")[0]):
            pairs.append(("derivatives are the CPU's", here, np.array([jax.grad(weighted)(sun) for sun in suns])))
    for what, found, expected in pairs:
        apart = float(np.abs(found - expected).max() / max(np.abs(expected).max(), 1e-3))
        yield Check(f"{name}: {what}", apart < 1e-2, f"apart by {apart:.1e} of the largest")
