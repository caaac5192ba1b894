"""The assignment's functions, in its own words; a comment marks each departure from the printed text."""

from collections.abc import Iterator

from raytrace.glsl.choices import Choices

__all__ = ["film_functions", "functions"]

_BACKGROUND = """\
vec3 backgroundColor(vec3 rd){
    if(rd.y < 0.0)
        return voidColor;
    const float skyGradient = 1./4.;
    vec3 skyColor = mix(skyColorLow, skyColorHigh, pow(rd.y, skyGradient));
    const float sunGradient = 2400.;
    float sunAmount = pow(max(dot(rd, normalize(sunDirection)), 0.), sunGradient);
    return mix(skyColor, sunColor, sunAmount);
}
"""

_TEXTBOOK = """\
float sphereIntersect(vec3 ro, vec3 rd, Sphere s){
    ro -= s.center;
    float b = dot(ro, rd);
    float c = dot(ro, ro) - s.radius*s.radius;
    float d = b*b - c;

    if(d < 0.0) return -1.; // No intersection

    d = sqrt(d);
    float t1 = -b - d;
    float t2 = -b + d;

    if(t1 < 0.0) return t2; // Potentially inside

    return t1;
}
"""

_ROBUST = """\
// Departure: the roots without cancellation, for small and far spheres (Haines, Guenther, Akenine-Moeller,
// 'Precision Improvements for Ray/Sphere Intersection', Ray Tracing Gems, chapter 7).
float sphereIntersect(vec3 ro, vec3 rd, Sphere s){
    ro -= s.center;
    float b = dot(ro, rd);
    vec3 nearest = ro - b*rd;
    float d = s.radius*s.radius - dot(nearest, nearest);

    if(d < 0.0) return -1.; // No intersection

    float c = dot(ro, ro) - s.radius*s.radius;
    float larger = b < 0.0 ? sqrt(d) - b : sqrt(d) + b;
    float most = larger*larger; // the roots' product is c: near the surface its error must not exceed that
    float q = b < 0.0 ? larger : -larger;
    float other = larger == 0.0 ? 0.0 : clamp(c, -most, most)/q;
    float t1 = b < 0.0 ? other : q;
    float t2 = b < 0.0 ? q : other;

    if(t1 < 0.0) return t2; // Potentially inside

    return t1;
}
"""

_CLOSEST_SPHERE = """\
float closestSphereIntersect(vec3 ro, vec3 rd, out int sphereIndex){
    float closestHit = infinity;
    float bestT = -1.0;
    sphereIndex = -1; // Departure: the printed text leaves it unset where no sphere is hit.
    for(int i = 0; i < %(count)s; i++){
        float t = sphereIntersect(ro, rd, %(item)s);
        if(t < 0.0 || t > closestHit) continue;
        closestHit = bestT = t;
        sphereIndex = i;
    }
    return bestT;
}
"""

_PLANE_INTERSECT = """\
float planeIntersect(vec3 ro, vec3 rd, vec3 n, vec3 p){
    return dot(p-ro, n)/dot(rd, n);
}
"""

_CLOSEST_PLANE = """\
// The nearest plane in front of the ray; infinity where there is none, as where the ray is parallel to it.
float closestPlaneIntersect(vec3 ro, vec3 rd, out int planeIndex){
    float closestHit = infinity;
    planeIndex = -1;
    for(int i = 0; i < planes.length(); i++){
        float t = planeIntersect(ro, rd, planes[i].normal, planes[i].point);
        if(t > 0.0 && t < closestHit){
            closestHit = t;
            planeIndex = i;
        }
    }
    return closestHit;
}
"""

_ANY_PLANE = """\
// Extension: planes that cast shadows.
bool anyPlaneIntersect(vec3 ro, vec3 rd){
    for(int i = 0; i < %(planes)s.length(); i++){
        float t = planeIntersect(ro, rd, %(planes)s[i].normal, %(planes)s[i].point);
        if(t > 0.0 && t < infinity) return true;
    }
    return false;
}
"""

_SHADOW_SPHERES = """\
    int ignore;
    float tSphere = closestSphereIntersect(ro, rd, ignore);
    return 1.-step(0.0, tSphere); // 1 if tSphere < 0 else 0
"""
_SHADOW_PLANES = "    if(anyPlaneIntersect(ro, rd)) return 0.;\n"
_SHADOW_NOTHING = "    return 1.; // Departure: there is no sphere.\n"

_CHECKERBOARD = """\
// checkerboard pattern based on position of point with a center line
vec3 checkerboard(vec3 point, float tileSize){
    vec2 p = point.xz / tileSize;
    vec2 t = floor(p+0.5);
    if(t.x == 0.0 || t.y == 0.0) // middle line for better orientation
        return vec3(1.0,0.8,0.4);
    return mix(vec3(1.), vec3(.1), mod(t.x+t.y, 2.));
}
"""
_COLORED_CHECKERBOARD = """\
// Departure: the colours of the checkerboard, and those of its center line, are the plane's own.
vec3 checkerboard(vec3 point, Plane plane){
    vec2 p = point.xz / plane.tileSize;
    vec2 t = floor(p+0.5);
    if(t.x == 0.0 || t.y == 0.0) // middle line for better orientation
        return plane.lineColor;
    return mix(plane.evenColor, plane.oddColor, mod(t.x+t.y, 2.));
}
"""

_TONE_MAPPERS = {
    "aces": "(x*(2.51*x+0.03))/(x*(2.43*x+0.59)+0.14)",
    "reinhard": "x/(1.+x)",
    "hable": "hable(2.*x)/hable(vec3(11.2))",
    "none": "x",
}
_TONE_MAPPER_NOTES = {
    "aces": "// Departure: the printed text has a bracket too many.\n",
    "reinhard": "// Extension: Reinhard et al., 'Photographic Tone Reproduction for Digital Images' (2002).\n",
    "hable": "// Extension: J. Hable, 'Uncharted 2: HDR Lighting' (2010).\n",
    "none": "// Extension: no tone mapping.\n",
}
_HABLE = """\
vec3 hable(vec3 x){
    return x*(0.14*x+1./60.)/(x*(0.15*x+0.5)+0.06); // without the cancellation of the printed difference
}
"""
_TRANSFERS = {"gamma2.2": "pow(%s, vec3(1.0/2.2))", "srgb": "srgb(%s)", "none": "%s"}
_SRGB = """\
// Extension: the transfer function of sRGB, IEC 61966-2-1.
vec3 srgb(vec3 x){
    return mix(1.055*pow(x, vec3(1.0/2.4)) - 0.055, 12.92*x, lessThanEqual(x, vec3(0.0031308)));
}
"""


def functions(choices: Choices) -> Iterator[str]:
    """The functions that the scene needs, in the assignment's order."""
    yield _BACKGROUND
    if choices.output != "linear":
        yield from film_functions(choices)
    if choices.spheres:
        yield _TEXTBOOK if choices.intersection == "textbook" else _ROBUST
        in_texture = choices.spheres_in_texture
        yield _CLOSEST_SPHERE % {
            "count": "sphereCount" if in_texture else "spheres.length()",
            "item": sphere_item("i", choices),
        }
    if choices.planes:
        yield _PLANE_INTERSECT
        yield _CLOSEST_PLANE
    if (choices.spheres or choices.planes) and choices.lighting != "off":
        if choices.lighting == "shadow":
            yield from _shadow_ray(choices)
        yield _light(choices)
    if choices.patterned:
        yield _CHECKERBOARD if choices.printed_checkerboard else _COLORED_CHECKERBOARD


def sphere_item(index: str, choices: Choices) -> str:
    """The sphere of that index."""
    return f"sphereAt({index})" if choices.spheres_in_texture else f"spheres[{index}]"


def film_functions(choices: Choices) -> Iterator[str]:
    """``tonemapAndGammaCorrect`` and what it calls."""
    if choices.tone_mapper == "hable":
        yield _HABLE
    if choices.transfer == "srgb":
        yield _SRGB
    clamped = f"clamp({_TONE_MAPPERS[choices.tone_mapper]}, 0.0, 1.0)"
    yield (
        f"{_TONE_MAPPER_NOTES[choices.tone_mapper]}"
        "vec3 tonemapAndGammaCorrect(const vec3 x){\n"
        f"    return {_TRANSFERS[choices.transfer] % clamped};\n"
        "}\n"
    )


def _shadow_ray(choices: Choices) -> Iterator[str]:
    body = _SHADOW_SPHERES if choices.spheres else _SHADOW_NOTHING
    if choices.shadow_planes:
        yield _ANY_PLANE % {"planes": "planes" if choices.all_planes_cast else "shadowPlanes"}
        body = _SHADOW_PLANES + body
    yield f"float shadowRay(vec3 ro, vec3 rd){{\n{body}}}\n"


def _light(choices: Choices) -> str:
    shadow = choices.lighting == "shadow"
    kept = "    steps.NdL = NdL;\n    steps.NdSky = NdSky;\n    steps.shadow = %s;\n" % ("shadow" if shadow else "1.")
    return (
        "vec3 lightAtPoint(vec3 point, vec3 N){\n"
        "    vec3 L = normalize(sunDirection);\n"
        "    float NdL = max(dot(N, L), 0.0);\n"
        "    float NdSky = clamp(0.5*N.y+0.5, 0.0, 1.0);\n"
        + ("    float shadow = shadowRay(point + 1e-3*N, L);\n" if shadow else "")
        + (kept if choices.output == "steps" else "")
        + f"    return sunColor * NdL{' * shadow' if shadow else ''} + skyColorHigh * NdSky;\n"
        "}\n"
    )
