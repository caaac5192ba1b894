"""Mistakes of one line, as students and engineers make them in the assignment's GLSL."""

from typing import NamedTuple

__all__ = ["MUTATIONS", "Mutation"]


class Mutation(NamedTuple):
    """A mistake: each text of `changes` is replaced by the other, wherever it stands."""

    name: str
    changes: tuple[tuple[str, str], ...]

    def applied(self, text: str) -> str | None:
        """The shader with the mistake; ``None`` where it has no such line."""
        if not all(old in text for old, _ in self.changes):
            return None
        for old, new in self.changes:
            text = text.replace(old, new)
        return text


def _mutation(name: str, old: str, new: str, *more: tuple[str, str]) -> Mutation:
    return Mutation(name, ((old, new), *more))


_DIRECTION = "mat3(viewToWorld) * pixelViewSpace"
_NORMAL = "hitPoint-spheres[sphereIndex].center"
_WIDTH = "dFdx(fragmentTextureCoordinates.x)"
_COORDINATES = "2. * fragmentTextureCoordinates - 1."
_SHADOW = "shadowRay(point + 1e-3*N, L)"
_TO_SUN = "dot(rd, normalize(sunDirection))"
_TILE = "mod(t.x+t.y, 2.)"
_GAMMA = "vec3(1.0/2.2)"
_LINES = "if(t.x == 0.0 || t.y == 0.0)"

MUTATIONS = (
    _mutation("shadow offset 1e-2", "1e-3*N", "1e-2*N"),
    _mutation("shadow offset 1e-4", "1e-3*N", "1e-4*N"),
    _mutation("no shadow offset", "point + 1e-3*N", "point"),
    _mutation("shadow ray from the wrong side", _SHADOW, "shadowRay(point - 1e-3*N, L)"),
    _mutation("shadow ray away from the sun", _SHADOW, "shadowRay(point + 1e-3*N, -L)"),
    _mutation("sun not normalised, light", "vec3 L = normalize(sunDirection)", "vec3 L = sunDirection"),
    _mutation("sun not normalised, sky", _TO_SUN, "dot(rd, sunDirection)"),
    _mutation("no t2 from inside a sphere", "if(t1 < 0.0) return t2;", ""),
    _mutation("the farther root", "return t1;", "return t2;"),
    _mutation("radius not squared", "s.radius*s.radius", "s.radius"),
    _mutation("radius 0.1 % too large", "s.radius*s.radius", "1.002001*s.radius*s.radius"),
    _mutation("first sphere at ties", "t > closestHit", "t >= closestHit"),
    _mutation("sphere's normal not normalised", f"normalize({_NORMAL})", _NORMAL),
    _mutation("sphere's normal inwards", "normalize(hitPoint-spheres", "-normalize(hitPoint-spheres"),
    _mutation("plane before every sphere", "tPlane < (t > 0.0 ? t : infinity)", "tPlane < infinity"),
    _mutation("plane behind the camera too", "if(t > 0.0 && t < closestHit)", "if(t < closestHit)"),
    _mutation("tiles without + 0.5", "floor(p+0.5)", "floor(p)"),
    _mutation("mod of a negative by truncation", _TILE, "(t.x+t.y - 2.*trunc((t.x+t.y)/2.))"),
    _mutation("tiles multiplied", _TILE, "mod(t.x*t.y, 2.)"),
    _mutation("tiles' colours exchanged", "mix(plane.evenColor, plane.oddColor", "mix(plane.oddColor, plane.evenColor"),
    _mutation("no centre lines", _LINES, "if(false)"),
    _mutation("one centre line", _LINES, "if(t.x == 0.0)"),
    _mutation("sky gradient 1/5", "skyGradient = 1./4.", "skyGradient = 1./5."),
    _mutation("sky gradient 0.26", "skyGradient = 1./4.", "skyGradient = 0.26"),
    _mutation("sun gradient 2000", "sunGradient = 2400.", "sunGradient = 2000."),
    _mutation("sun gradient 2399", "sunGradient = 2400.", "sunGradient = 2399."),
    _mutation("sky's colours exchanged", "mix(skyColorLow, skyColorHigh", "mix(skyColorHigh, skyColorLow"),
    _mutation("a second sun behind", f"max({_TO_SUN}, 0.)", f"abs({_TO_SUN})"),
    _mutation("horizon too high", "if(rd.y < 0.0)", "if(rd.y < 0.01)"),
    _mutation("sky light not remapped", "clamp(0.5*N.y+0.5, 0.0, 1.0)", "max(N.y, 0.0)"),
    _mutation("sunlight not clamped", "max(dot(N, L), 0.0)", "dot(N, L)"),
    _mutation("sky light of the low colour", "+ skyColorHigh * NdSky", "+ skyColorLow * NdSky"),
    _mutation("ACES 2.51 as 2.15", "2.51*x", "2.15*x"),
    _mutation("ACES 0.03 as 0.003", "2.51*x+0.03", "2.51*x+0.003"),
    _mutation("ACES 0.59 as 0.58", "2.43*x+0.59", "2.43*x+0.58"),
    _mutation("ACES 0.14 as 0.15", "+0.14", "+0.15"),
    _mutation("no clamp", "clamp((x*(2.51", "((x*(2.51", (", 0.0, 1.0), vec3(1.0/2.2))", "), vec3(1.0/2.2))")),
    _mutation("gamma 2.4", _GAMMA, "vec3(1.0/2.4)"),
    _mutation("gamma 2.25", _GAMMA, "vec3(1.0/2.25)"),
    _mutation("no gamma", _GAMMA, "vec3(1.0)"),
    _mutation(
        "sRGB for 2.2",
        "return pow(clamp((x*(2.51*x+0.03))/(x*(2.43*x+0.59)+0.14), 0.0, 1.0), vec3(1.0/2.2));",
        "vec3 c = clamp((x*(2.51*x+0.03))/(x*(2.43*x+0.59)+0.14), 0.0, 1.0); "
        "return mix(1.055*pow(c, vec3(1.0/2.4)) - 0.055, 12.92*c, lessThanEqual(c, vec3(0.0031308)));",
    ),
    _mutation(
        "ray not normalised", "normalize(mat3(viewToWorld) * pixelViewSpace)", "mat3(viewToWorld) * pixelViewSpace"
    ),
    _mutation("y flipped", _COORDINATES, f"({_COORDINATES}) * vec2(1., -1.)"),
    _mutation("half a pixel to the right", _COORDINATES, f"{_COORDINATES} + vec2({_WIDTH}, 0.)"),
    _mutation("aspect inverted", "vec4(pixelNdc, 1., 1.)", "vec4(pixelNdc * vec2(9./16., 16./9.), 1., 1.)"),
    _mutation("mediump floats", "precision highp float", "precision mediump float"),
)
