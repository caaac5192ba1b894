"""No valid scene gives NaN or infinity, whatever its numbers are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import raytrace
from raytrace.errors import InputError
from raytrace.scene.check import check_scene
from raytrace.scene.kinds import BRIGHTEST, LARGEST, LONGEST, MOST_EXPOSURE, SHORTEST
from tests.scenes import examples, some

SIZE = (9, 5)


class Numbers:
    """Numbers of any order of magnitude, made of random bytes: Hypothesis draws those fastest."""

    BYTES = 240

    def __init__(self, data: bytes):
        self.data = iter(data)

    def size(self, low, high):
        """From `low` to `high`, both included, evenly by the logarithm; now and then 1."""
        share = next(self.data) / 254
        return 1.0 if share > 1 else float(np.clip(low ** (1 - share) * high**share, low, high))

    def signed(self, low, high):
        return (next(self.data) % 3 - 1.0) * self.size(low, high)

    def vector(self, low, high):
        return np.array([self.signed(low, high) for _ in range(3)])

    def position(self, near=None):
        """Anywhere, or where something else is."""
        position = self.vector(SHORTEST, LONGEST)
        return near if near is not None and next(self.data) % 4 == 0 else position

    def direction(self):
        return self.vector(1e-45, LARGEST)

    def color(self):
        return np.abs(self.vector(1e-45, BRIGHTEST))

    def matrix(self):
        return np.array([[self.signed(SHORTEST, LONGEST) for _ in range(4)] for _ in range(4)])

    def length(self):
        return self.size(SHORTEST, LONGEST)

    def one_of(self, choices):
        return choices[next(self.data) % len(choices)]


@st.composite
def extreme_scenes(draw, lighting=("off", "on", "shadow"), mappers=("aces", "reinhard", "hable", "none")):
    """Three spheres and a plane, of admitted numbers of any size."""
    some = Numbers(draw(st.binary(min_size=Numbers.BYTES, max_size=Numbers.BYTES)))
    position = some.position()
    target = some.position(near=position - [0.0, 0.0, 1.0])
    cameras = (
        raytrace.PerspectiveCamera(position, target),
        raytrace.OrthographicCamera(some.length(), position, target),
        raytrace.MatrixCamera(some.matrix(), some.matrix()),
    )
    scene = raytrace.Scene(
        spheres=raytrace.Spheres(
            center=np.stack([some.position(near=position) for _ in range(3)]),
            radius=np.array([some.length() for _ in range(3)]),
            color=np.stack([some.color() for _ in range(3)]),
        ),
        planes=(
            raytrace.Plane(
                point=some.position(near=position),
                normal=some.direction(),
                pattern=raytrace.Checkerboard(
                    tile_size=some.length(), even=some.color(), odd=some.color(), line=some.color()
                ),
                casts_shadow=True,
            ),
        ),
        sun=raytrace.Sun(direction=some.direction(), color=some.color()),
        sky=raytrace.Sky(low=some.color(), high=some.color(), void=some.color()),
        lighting=some.one_of(lighting),
        camera=some.one_of(cameras),
        film=raytrace.Film(
            exposure=some.one_of([0.0, MOST_EXPOSURE, -MOST_EXPOSURE]),
            tone_mapper=some.one_of(mappers),
            transfer=some.one_of(["gamma2.2", "srgb", "none"]),
        ),
    )
    try:
        check_scene(scene)
    except InputError:
        assume(False)
    return scene


def assert_is_an_image(image):
    image = np.asarray(image)
    assert np.isfinite(image).all()
    assert image.min() >= 0
    assert image.max() <= 1


@examples(40, 300)
@given(
    scene=extreme_scenes(),
    dtype=st.sampled_from(["float32", "float64"]),
    intersection=st.sampled_from(["textbook", "robust"]),
    shadow_start=st.sampled_from(["offset", "surface"]),
    antialias=st.sampled_from(["none", "edges"]),
)
def test_numpy_draws_any_scene(scene, dtype, intersection, shadow_start, antialias):
    choices = {"intersection": intersection, "shadow_start": shadow_start, "antialias": antialias}
    assert_is_an_image(raytrace.render(scene, SIZE, backend="numpy", dtype=dtype, **choices))


@pytest.mark.parametrize("dtype", some(["float32", "float64"], "float32"))
@examples(100, 850)
@given(scene=extreme_scenes(lighting=("shadow",), mappers=("aces",)))
def test_jax_draws_any_scene(dtype, scene):
    # Values alone differ, so that one program draws them all.
    film = replace(scene.film, transfer="gamma2.2", exposure=np.float64(1.0) * (scene.film.exposure or 1.0))
    camera = scene.camera
    if isinstance(camera, raytrace.OrthographicCamera):
        camera = raytrace.PerspectiveCamera(camera.position, camera.target)
    assert_is_an_image(raytrace.render(replace(scene, film=film, camera=camera), SIZE, dtype=dtype))


def test_white_is_white_however_bright():
    """Linear light at the end of float32, and infinite: a tone mapper would divide infinity by infinity."""
    from raytrace.language.glsl import Vec3
    from raytrace.scene.to_uniforms import program_of
    from raytrace.shader.film import tonemap_and_gamma_correct

    bright = np.array([1e15, 1e30, 3e38, np.inf], np.float32)
    for mapper in ("aces", "reinhard", "none"):
        program = program_of(raytrace.Scene(film=raytrace.Film(tone_mapper=mapper)), "robust")
        np.testing.assert_array_equal(tonemap_and_gamma_correct(Vec3(bright, bright, bright), program).x, 1)
