import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import raytrace
from raytrace.arithmetic.intervals import GLSL_HIGHP, REAL, IntervalNamespace
from raytrace.language.glsl import Vec3
from raytrace.language.tree import tree_map
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS, develop
from tests.strategies import numbers, vec3


def film(linear, **settings):
    scene = raytrace.Scene(film=raytrace.Film(**settings))
    return develop(vec3(linear), uniforms_of(scene, 1.0).film, program_of(scene, "textbook"))


def test_the_assignments_film_by_hand():
    """x = 1: (2.51 + 0.03) / (2.43 + 0.59 + 0.14) = 2.54 / 3.16 = 0.80380, to the power 1/2.2 = 0.90551."""
    assert film([1, 0, 1e3]).x == pytest.approx((2.54 / 3.16) ** (1 / 2.2), abs=1e-15)
    assert film([1, 0, 1e3]).y == 0
    # The curve goes to 2.51 / 2.43 > 1, and is clamped.
    assert film([1, 0, 1e3]).z == 1


def test_reinhard_by_hand():
    """x / (1 + x) of 1 and 3 is 1/2 and 3/4."""
    assert film([1, 3, 0], tone_mapper="reinhard", transfer="none") == (0.5, 0.75, 0)


def test_hable_by_hand():
    """Linear white, 11.2 / 2 after the bias of 2, becomes 1; black stays black.

    Of 1: f(2) = (2 * (0.3 + 0.05) + 0.004) / (2 * (0.3 + 0.5) + 0.06) - 1/15 = 0.704 / 1.66 - 1/15 = 0.357430;
    f(11.2) = (11.2 * 1.73 + 0.004) / (11.2 * 2.18 + 0.06) - 1/15 = 19.38 / 24.476 - 1/15 = 0.725129.
    """
    display = film([5.6, 0, 1], tone_mapper="hable", transfer="none")
    assert display == pytest.approx((1, 0, (0.704 / 1.66 - 1 / 15) / (19.38 / 24.476 - 1 / 15)), abs=1e-15)


def test_srgb_by_hand():
    """0.002 is on the straight part: 12.92 * 0.002; above it the power 1/2.4 holds: 1.055 * 0.5**(1/2.4) - 0.055."""
    display = film([0.002, 0.5, 1], tone_mapper="none", transfer="srgb")
    assert display == pytest.approx((0.02584, 1.055 * 0.5 ** (1 / 2.4) - 0.055, 1), abs=1e-15)


def test_srgb_is_colour_sciences():
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

    x = np.linspace(0, 1, 1001)
    display = film(np.stack([x, x, x], -1), tone_mapper="none", transfer="srgb")
    np.testing.assert_allclose(display.y, colour.models.eotf_inverse_sRGB(x), atol=1e-7)


def test_exposure_is_in_stops():
    """+3 EV is a factor of 8."""
    assert film([0.1, 0.01, 0], exposure=3, tone_mapper="none", transfer="none") == pytest.approx((0.8, 0.08, 0))


def test_the_default_film_has_nothing_to_do_before_the_tone_mapper():
    assert uniforms_of(raytrace.Scene(), 1.0).film == (None, None)


@pytest.mark.parametrize("white_point", [3200.0, (0.35, 0.36)])
def test_the_white_point_becomes_white(white_point):
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour

    xy = white_point if isinstance(white_point, tuple) else colour.temperature.CCT_to_xy_Kang2002(white_point)
    light = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB @ colour.xy_to_XYZ(xy)
    red, green, blue = film(light / 4, white_point=white_point, tone_mapper="none", transfer="none")
    assert red == pytest.approx(green, rel=1e-3)
    assert green == pytest.approx(blue, rel=1e-3)


@given(st.sampled_from(list(TONE_MAPPERS)), st.sampled_from(list(TRANSFERS)), numbers(0, 1000), numbers(0, 1000))
def test_display_values_are_within_0_and_1_and_keep_the_order(mapper, transfer, a, b):
    display = [film([x, x, x], tone_mapper=mapper, transfer=transfer).x for x in sorted((a, b))]
    assert 0 <= display[0] <= display[1] + 1e-12 <= 1 + 1e-12


def test_a_tone_mapper_of_ones_own():
    assert film([0.25, 0.5, 1], tone_mapper=lambda x: x * x, transfer="none") == (0.0625, 0.25, 1)


#: A blue that the white balance takes out of gamut: its red and green become negative.
BLUE = (0, 0, 3.24)


@pytest.mark.parametrize("mapper", TONE_MAPPERS)
@pytest.mark.parametrize("exposure", [0.0, 1.0, 1.5, 2.0, 16.0])
def test_light_that_a_white_point_makes_negative_is_black(mapper, exposure):
    """Whatever the tone mapper makes of negative numbers: ACES rises below 0, Reinhard's has a pole at -1."""
    settings = {"exposure": exposure, "tone_mapper": mapper}
    balanced = film(BLUE, exposure=exposure, white_point=3000.0, tone_mapper=lambda x: x, transfer="none")
    display = film(BLUE, white_point=3000.0, **settings)
    assert (display.x, display.y) == (0, 0)
    assert display.z > 0.5
    # Blue is what it is without the other two.
    assert display.z == film([0, 0, balanced.z], tone_mapper=mapper).z or balanced.z == 1


@pytest.mark.parametrize("mapper", TONE_MAPPERS)
def test_without_a_white_point_nothing_is_clamped_before_the_tone_mapper(mapper):
    """A scene has no negative light; what a foreign file has is developed as it is."""
    seen = []
    program = program_of(raytrace.Scene(film=raytrace.Film(tone_mapper=lambda x: seen.append(x) or x)), "textbook")
    develop(vec3([-1, 0, 1]), uniforms_of(raytrace.Scene(), 1.0).film, program)
    assert [float(x) for x in seen[0]] == [-1, 0, 1]


def test_derivatives_of_light_that_a_white_point_makes_negative_are_finite():
    """Reinhard's pole lay between 1 and 2 stops."""
    import jax
    import jax.numpy as jnp

    def display(linear, stops):
        scene = raytrace.Scene(film=raytrace.Film(exposure=stops, white_point=3000.0, tone_mapper="reinhard"))
        shown = develop(Vec3(*linear), uniforms_of(scene, 1.0).film, program_of(scene, "robust"))
        return shown.x + shown.y + shown.z

    def slopes(stops):
        return jax.grad(display, argnums=(0, 1))(jnp.array(BLUE), stops)

    by_light, by_stops = jax.jit(jax.vmap(slopes))(jnp.linspace(1.0, 2.0, 257))
    assert np.isfinite(by_light).all()
    assert np.isfinite(by_stops).all()
    assert (np.asarray(by_light)[:, 2] > 0).all()


@pytest.mark.parametrize("mapper", ["aces", "reinhard"])
def test_every_arithmetic_and_every_bound_agrees_on_negative_light(mapper):
    """Red and green are exactly 0 in floats; the bounds of both models hold that and are as narrow as elsewhere."""
    import jax.numpy as jnp

    scene = raytrace.Scene(film=raytrace.Film(1.3, 3000.0, mapper))
    given, program = uniforms_of(scene, 1.0).film, program_of(scene, "robust")

    def display(number):
        return develop(Vec3(*map(number, BLUE)), tree_map(number, given), program)

    for number in (np.float32, np.float64, np.longdouble, jnp.float32):
        assert display(number)[:2] == (0, 0)
    for model in (REAL, GLSL_HIGHP):
        red, green, blue = display(IntervalNamespace(model).given)
        assert red.low == green.low == 0
        assert max(red.high, green.high) <= 1e-6
        assert blue.low <= display(np.float64).z <= blue.high <= blue.low + 1e-4
