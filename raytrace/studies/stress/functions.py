"""Functions of one number or vector at their ends: powers, tone mapping, normalisation, the sun's length."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.arithmetic.exact import precision
from raytrace.language.glsl import Vec3, normalize, pow
from raytrace.language.literal import literal
from raytrace.scene.data import Film, Scene, Sun
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.film import TONE_MAPPERS, tonemap_and_gamma_correct
from raytrace.shader.sky import SKY_GRADIENT, SUN_GRADIENT
from raytrace.studies.stress.arithmetics import exactly, of_floats
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.measure import INPUT, Measurement, at_one, summary, ulps

__all__ = ["FunctionStress"]

GAMMA = literal("5/11")
#: Binary digits: nothing is decided here.
BITS = 200
#: Results below this many times the smallest normal number are counted apart: rounding may make them subnormal, and
#: JAX takes those for 0.
NORMAL = 1.001
#: 1 - x of the x whose power 2400 is the smallest normal number of float32.
LAST_OF_THE_LOBE = 1 - 2.0 ** (-126 / 2400)


class FunctionStress:
    """What has no decision to take: only errors."""

    def __init__(self, effort: Effort):
        self.effort = effort
        self.random = np.random.default_rng((2, effort.seed) if effort.seed else 2)
        # Exact powers take their time, and so many say enough.
        self.cases = effort.cases // 8
        self.normalizers = [(a.name, a.dtype, a.of(normalize)) for a in of_floats()]

    def gamma(self) -> Iterator[Measurement]:
        yield from self._of_a_number("gamma", lambda x: pow(x, GAMMA), -44, 0)

    def sky_gradient(self) -> Iterator[Measurement]:
        yield from self._of_a_number("sky_gradient", lambda x: pow(x, SKY_GRADIENT), -44, 0)

    def sun_lobe(self) -> Iterator[Measurement]:
        """By how far the cosine is from 1, where the result is a normal number."""
        places = sorted([*self.effort.decades(-7, -1), LAST_OF_THE_LOBE])
        yield from self._lobe("sun_lobe", places, lambda result, normal: result >= normal)

    def lobe_vanishes(self) -> Iterator[Measurement]:
        """The same where the result is subnormal in float32, or would be 0."""
        yield from self._lobe("lobe_vanishes", [LAST_OF_THE_LOBE, 0.1], lambda result, normal: result < normal)

    def tone_mapping(self) -> Iterator[Measurement]:
        for name in TONE_MAPPERS:
            program = program_of(Scene(film=Film(tone_mapper=name)), "robust")

            def display(x: Any, program: Any = program) -> Any:
                return tonemap_and_gamma_correct(Vec3(x, x, x), program).x

            yield from self._of_a_number("tone_mapping", display, -44, 38, formula=name)

    def normalization(self) -> Iterator[Measurement]:
        for length in self.effort.decades(-44, 38):
            yield from self._vectors("normalization", length, lambda v: v)

    def sun(self) -> Iterator[Measurement]:
        """The scene's direction of any length, on its way to the shader and within."""

        def given(direction: Vec3) -> Vec3:
            suns = np.stack(direction, axis=-1).astype(np.float64)
            uniforms = [uniforms_of(replace(Scene(), sun=Sun(direction=sun)), 1.0).sun.direction for sun in suns]
            return Vec3(*(np.array(component).astype(np.longdouble) for component in zip(*uniforms, strict=True)))

        for length in self.effort.decades(-20, 20):
            yield from self._vectors("sun", length, given, cases=self.cases // 4)

    def _lobe(self, axis: str, places: Iterable[float], counted: Callable) -> Iterator[Measurement]:
        yield from self._at_places(axis, lambda x: pow(x, SUN_GRADIENT), places, lambda x: 1 - x, counted=counted)

    def _of_a_number(
        self, axis: str, function: Callable, low: int, high: int, formula: str = ""
    ) -> Iterator[Measurement]:
        yield from self._at_places(axis, function, self.effort.decades(low, high), formula=formula)

    def _at_places(
        self,
        axis: str,
        function: Callable,
        places: Iterable[float],
        argument: Callable = lambda x: x,
        formula: str = "",
        counted: Callable | None = None,
    ) -> Iterator[Measurement]:
        """Measure `function` at `argument` of each place; `counted` tells which results count."""
        runs = [(a.name, a.dtype, a.of(function)) for a in of_floats()]
        # An eighth of a decade about each place.
        spread = 10 ** self.random.uniform(-1 / 16, 1 / 16, self.cases)
        for x in places:
            for dtype in (np.float32, np.float64):
                with np.errstate(all="ignore"):
                    args = argument(np.longdouble(x) * spread).astype(dtype)
                args = args[np.isfinite(args)]
                exact = exactly(function, args, bits=BITS)
                if counted is not None:
                    among = counted(exact.floats(), NORMAL * float(np.finfo(dtype).smallest_normal))
                    args, exact = args[among], exact[among]
                for name, its_dtype, run in runs:
                    if its_dtype is dtype and args.size:
                        with precision():
                            errors = ulps(run(args), exact, dtype)
                        yield Measurement(axis, x, f"{name} {formula}".rstrip(), args.size, None, **summary(errors))

    def _vectors(self, axis: str, length: float, given: Callable, cases: int = 0) -> Iterator[Measurement]:
        directions = self.random.normal(size=(cases or self.cases, 3)).astype(np.longdouble)
        directions *= np.longdouble(length) / np.sqrt((directions**2).sum(axis=1))[:, None]
        vectors = given(Vec3(*np.moveaxis(directions, -1, 0)))
        ideal = exactly(normalize, Vec3(*np.moveaxis(directions, -1, 0)))
        for name, dtype, run in self.normalizers:
            with np.errstate(all="ignore"):
                rounded = Vec3(*(component.astype(dtype) for component in vectors))
            exact = exactly(normalize, rounded)
            found = run(rounded)
            with precision():
                if name.startswith("numpy"):
                    moved = at_one(Vec3(*(component.floats(np.longdouble) for component in exact)), ideal, dtype)
                    yield Measurement(axis, length, f"{INPUT}, {dtype.__name__}", moved.size, None, **summary(moved))
                errors = at_one(found, exact, dtype)
            yield Measurement(axis, length, name, errors.size, None, **summary(errors))
