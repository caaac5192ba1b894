"""From linear light to display values (assignment, 'Skybox': tone mapping and colour space conversion)."""

from collections.abc import Callable
from typing import TypeAlias

from raytrace.language.control import step
from raytrace.language.glsl import Vec3, clamp, maximum, minimum, pow, select
from raytrace.language.literal import literal
from raytrace.shader.uniforms import FilmUniforms, Program

__all__ = ["TONE_MAPPERS", "TRANSFERS", "develop", "tonemap_and_gamma_correct"]


def aces(x: Vec3) -> Vec3:
    """The assignment's curve, after K. Narkowicz, 'ACES Filmic Tone Mapping Curve' (2015)."""
    a, b, c, d, e = map(literal, ("2.51", "0.03", "2.43", "0.59", "0.14"))
    return (x * (a * x + b)) / (x * (c * x + d) + e)


def reinhard(x: Vec3) -> Vec3:
    """E. Reinhard et al., 'Photographic Tone Reproduction for Digital Images' (2002), equation 3."""
    return x / (1 + x)


def hable(x: Vec3) -> Vec3:
    """J. Hable, 'Uncharted 2: HDR Lighting' (GDC 2010): exposure bias 2, linear white at 11.2.

    His curve is (x (A x + C B) + D E) / (x (A x + B) + D F) - E / F. The two quotients cancel in the shadows, so here
    the difference is carried out: what is left has a factor x.
    """
    A, B, C, D, E, F, W = map(literal, ("0.15", "0.5", "0.1", "0.2", "0.02", "0.3", "11.2"))

    def curve(x):
        return x * ((1 - E / F) * A * x + (C - E / F) * B) / (x * (A * x + B) + D * F)

    return curve(2 * x) / curve(W.like(x.x if isinstance(x, Vec3) else x))


def linear(x: Vec3) -> Vec3:
    """No change."""
    return x


def gamma22(x: Vec3) -> Vec3:
    """The assignment's approximation of sRGB: the power 1/2.2."""
    return pow(x, literal("5/11"))


def srgb(x: Vec3) -> Vec3:
    """The transfer function of sRGB, IEC 61966-2-1."""
    low = literal("12.92") * x
    high = literal("1.055") * pow(x, literal("5/12")) - literal("0.055")
    return Vec3(*(select(c <= literal("0.0031308").like(c), a, b) for c, a, b in zip(x, low, high, strict=True)))


#: Linear light that is as good as infinite. Its square, ten times over, is finite in float32.
BRIGHTEST = 2.0**60

Curve: TypeAlias = Callable[[Vec3], Vec3]

TONE_MAPPERS: dict[str, Curve] = {"aces": aces, "reinhard": reinhard, "hable": hable, "none": linear}
TRANSFERS: dict[str, Curve] = {"gamma2.2": gamma22, "srgb": srgb, "none": linear}


@step
def tonemap_and_gamma_correct(x: Vec3, program: Program) -> Vec3:
    """Display values in [0, 1] of linear light: the tone mapper, a clamp, the transfer function.

    The tone mapper is given at most `BRIGHTEST`, which every one of them takes for white as it does all above: it
    squares its argument, and infinity divided by itself is NaN.
    """
    tone_mapper, transfer = named(TONE_MAPPERS, program.tone_mapper), named(TRANSFERS, program.transfer)
    return transfer(clamp(tone_mapper(minimum(x, BRIGHTEST)), 0, 1))


def named(curves: dict[str, Curve], curve: str | Curve) -> Curve:
    """Return the curve of that name; a function is its own curve."""
    return curves[curve] if isinstance(curve, str) else curve


@step
def develop(linear: Vec3, film: FilmUniforms, program: Program) -> Vec3:
    """Display values of the linear image: exposure and white balance, where there are any, then the assignment's.

    White balance gives saturated colours negative components: such a colour lies outside the display's gamut. They
    become 0. Tone mappers are made for light, which is never negative: below 0 they have poles, and some rise there.
    """
    if film.exposure is not None:
        linear = film.exposure * linear
    if film.white_balance is not None:
        linear = maximum(film.white_balance * linear, 0)
    return tonemap_and_gamma_correct(linear, program)
