"""Random rays and scenes for the laws."""

import numpy as np
from hypothesis import strategies as st

import raytrace
from raytrace.language.glsl import Vec3


def numbers(low, high):
    """Floats that float32 holds exactly, so that rounding a scene changes nothing."""
    low, high = float(np.float32(low)), float(np.float32(high))
    return st.floats(low, high, width=32, allow_nan=False, allow_infinity=False, allow_subnormal=False)


def vectors(low, high):
    return st.tuples(*[numbers(low, high)] * 3)


def unit(vector, dtype=np.float64):
    vector = np.asarray(vector, dtype)
    return vector / np.sqrt((vector**2).sum())


directions = vectors(-1, 1).filter(lambda v: np.dot(v, v) > 0.01)
positions = vectors(-10, 10)
radii = numbers(0.01, 5)
colors = vectors(0, 1)


def vec3(array, dtype=np.float64):
    """The components along the last axis as a `Vec3` of arrays of `dtype`."""
    return Vec3(*np.moveaxis(np.asarray(array, dtype), -1, 0))


@st.composite
def spheres(draw, least=0, most=6):
    n = draw(st.integers(least, most))
    return raytrace.Spheres(
        center=np.reshape([draw(positions) for _ in range(n)], (-1, 3)).astype(float),
        radius=np.array([draw(radii) for _ in range(n)], dtype=float),
        color=np.reshape([draw(colors) for _ in range(n)], (-1, 3)).astype(float),
    )


@st.composite
def planes(draw):
    pattern = draw(
        st.one_of(
            st.builds(raytrace.Checkerboard, tile_size=numbers(0.125, 4), even=colors, odd=colors, line=colors),
            st.builds(raytrace.Plain, color=colors),
        )
    )
    return raytrace.Plane(
        point=draw(positions), normal=draw(directions), pattern=pattern, casts_shadow=draw(st.booleans())
    )


@st.composite
def cameras(draw, orthographic=None):
    """A camera somewhere, turned about y first: it never looks along up. Of either kind, unless that is given."""
    position = np.array(draw(positions))
    angle, height = draw(numbers(-3, 3)), draw(numbers(-1, 1))
    placed = {"position": position, "target": position + np.array([np.sin(angle), height, np.cos(angle)])}
    if not (draw(st.booleans()) if orthographic is None else orthographic):
        return raytrace.PerspectiveCamera(**placed, field_of_view=draw(numbers(10, 120)))
    return raytrace.OrthographicCamera(**placed, height=draw(numbers(0.5, 20)))


@st.composite
def scenes(draw):
    return raytrace.Scene(
        spheres=draw(spheres()),
        planes=tuple(draw(st.lists(planes(), max_size=3))),
        sun=raytrace.Sun(direction=draw(directions), color=draw(colors)),
        lighting=draw(st.sampled_from(["off", "on", "shadow"])),
        camera=draw(cameras()),
        film=raytrace.Film(
            exposure=draw(st.sampled_from([0.0, 1.5, -2.0])),
            white_point=draw(st.sampled_from([None, None, 4000.0, (0.3, 0.35)])),
            tone_mapper=draw(st.sampled_from(["aces", "reinhard", "hable", "none"])),
            transfer=draw(st.sampled_from(["gamma2.2", "srgb", "none"])),
        ),
    )


def many(n, seed=0):
    """n small spheres above the ground."""
    random = np.random.default_rng(seed)
    return raytrace.Spheres(
        center=random.uniform([-3, -0.4, -6], [3, 2, -1], (n, 3)),
        radius=random.uniform(0.05, 0.3, n),
        color=random.uniform(0.2, 1, (n, 3)),
    )
