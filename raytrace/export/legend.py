"""How the page shows each step of the shader: its values are not all colours."""

from raytrace.glsl.numbers import number
from raytrace.shader.main import Steps

__all__ = ["legend", "with_step_colors"]

#: By step: the colour, in GLSL, of a `value` (its components as a vec3), and the same in words.
#: `hit` is false where the sky is seen; {d} is a distance.
STEP_COLORS = {
    "pixelNdc": ("vec3(0.5*value.xy + 0.5, 0.)", "red and green are 0.5*pixelNdc + 0.5"),
    "rd": ("0.5*value + 0.5", "red, green and blue are 0.5*rd + 0.5"),
    "t": (
        "hit ? vec3({d} / ({d} + value.x)) : vec3(0.1, 0.2, 0.5)",
        "brightness is d / (d + t) with d = {d}: white is near, black far; the sky is blue",
    ),
    "index": (
        "hit ? 0.5 + 0.5*cos(6.2831853*(0.618034*value.x + vec3(0., 1., 2.)/3.)) : vec3(0)",
        "a false colour for each sphere and, numbered after them, each plane; the sky is black",
    ),
    "hitPoint": ("fract(value)", "red, green and blue are fract(hitPoint), a cell for each unit; the sky is black"),
    "N": ("0.5*value + 0.5", "red, green and blue are 0.5*N + 0.5; the sky, without a normal, is grey"),
    "NdL": ("value.xxx", "brightness is NdL, black to white for 0 to 1"),
    "NdSky": ("value.xxx", "brightness is NdSky, black to white for 0 to 1"),
    "shadow": ("value.xxx", "white is lit, black is in shadow; the sky is black"),
    "albedo": ("value", "the colour as it is, linear, cut off at 1; the sky is black"),
    "linear": ("value", "linear light as it is, cut off at 1: before exposure, tone mapper and transfer function"),
    "display": ("value", "the final picture"),
}

_FUNCTION = """\
// Not of the assignment: the step that is shown, as a colour to look at.
vec4 viewedStep(vec3 linear, vec3 display){{
    vec3 value = stepColor(linear, display).rgb;
    bool hit = steps.index >= 0;
{cases}\
    return vec4(value, 1.);
}}

"""


def with_step_colors(shader: str, distance: float) -> str:
    """A shader text of the output "steps" that gives colours to look at; `distance` is where t is half bright."""
    cases = "".join(
        f"    if(shownStep == {i}) value = {STEP_COLORS[name][0].format(d=number(distance))}; // {name}\n"
        for i, name in enumerate(Steps._fields)
    )
    for old, new in (
        ("void main(){", _FUNCTION.format(cases=cases) + "void main(){"),
        ("fragColor = stepColor(", "fragColor = viewedStep("),
    ):
        assert shader.count(old) == 1, old
        shader = shader.replace(old, new)
    return shader


def legend(distance: float) -> dict[str, str]:
    """What the colours mean, by step."""
    return {name: STEP_COLORS[name][1].format(d=f"{distance:.4g}") for name in Steps._fields}
