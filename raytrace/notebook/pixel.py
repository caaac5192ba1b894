"""Every step at one pixel, beside its line of GLSL."""

import numpy as np

from raytrace.glsl.main import before_tone_mapping
from raytrace.rendering import Rendering
from raytrace.scene.data import OrthographicCamera, Plain, Scene
from raytrace.shader.main import COMPONENTS

__all__ = ["pixel_report"]


def _camera_lines(scene: Scene) -> dict[str, str]:
    parallel = isinstance(scene.camera, OrthographicCamera)
    return {
        "pixelNdc": "vec2 pixelNdc = 2. * fragmentTextureCoordinates - 1.;",
        "rd": "// parallel rays, an extension: the camera's -z"
        if parallel
        else "vec3 rd = normalize(mat3(viewToWorld) * pixelViewSpace);",
        "index": "out int sphereIndex // planes are counted after the spheres",
    }


def _film_line(scene: Scene) -> dict[str, str]:
    film = scene.film
    color = before_tone_mapping(bool(film.exposure != 0), film.white_point is not None)
    if (film.tone_mapper, film.transfer) == ("aces", "gamma2.2"):
        return {"display": f"fragColor = vec4(tonemapAndGammaCorrect({color}), 1.);"}
    given = "" if color == "col" else f" of {color}"
    return {"display": f"// tone mapper {film.tone_mapper}, transfer function {film.transfer}{given}"}


def _sky_lines() -> dict[str, str]:
    return {"t": "// neither a sphere nor a plane: t <= 0", "linear": "col = backgroundColor(rd);"}


def _surface_lines(scene: Scene, index: int) -> dict[str, str]:
    """The lines of a pixel that shows sphere `index` or, numbered after the spheres, a plane."""
    plane = index - len(scene.spheres.radius)
    if plane < 0:
        color = "spheres[sphereIndex].color"
        lines = {
            "t": "float t = closestSphereIntersect(ro,rd,sphereIndex);",
            "N": "vec3 normal = normalize(hitPoint-spheres[sphereIndex].center);",
        }
    else:
        plain = isinstance(scene.planes[plane].pattern, Plain)
        color = "// the plane's own colour" if plain else "checkerboard(hitPoint, tileSize)"
        lines = {"t": "float t = planeIntersect(ro,rd,n,p);", "N": "// the plane's normal"}
    lines |= {"hitPoint": "vec3 hitPoint = ro + t*rd;", "albedo": color}
    if scene.lighting == "off":
        return lines | {"linear": "// the colour itself: lighting is off"}
    cast = "float shadow = shadowRay(point + 1e-3*N, L);" if scene.lighting == "shadow" else "// 1: without shadows"
    return lines | {
        "NdL": "float NdL = max(dot(N,L),0.0);",
        "NdSky": "float NdSky = clamp(0.5*N.y+0.5, 0.0, 1.0 );",
        "shadow": cast,
        "linear": "col = light * the colour;" if color.startswith("//") else f"col = light*{color};",
    }


def pixel_report(rendering: Rendering, x: int, y: int) -> str:
    """Every step at pixel (x, y) beside its line of GLSL: each number in decimal and in hexadecimal notation.

    `rendering` is one of the output "steps". Steps that the pixel does not come by are left out.

    Raises:
        InputError: there is no such pixel.
    """
    steps, scene = rendering.pixel(x, y), rendering.scene
    index, spheres = int(steps["index"]), len(scene.spheres.radius)
    seen = "sky" if index < 0 else f"sphere {index}" if index < spheres else f"plane {index - spheres}"
    glsl = _camera_lines(scene) | (_sky_lines() if index < 0 else _surface_lines(scene, index)) | _film_line(scene)
    width, height, _ = rendering.frame
    lines = [f"pixel {x} {y} of {width}x{height}, {rendering.options.backend} {rendering.options.dtype}: {seen}"]
    for name in (name for name in COMPONENTS if name in glsl):
        lines += ["", f"{name:9} {glsl[name]}"]
        for axis, number in zip("xyz", np.atleast_1d(steps[name]), strict=False):
            label = axis if COMPONENTS[name] > 1 else " "
            lines.append(f"  {label} {number!s:>24}  {'' if name == 'index' else _hex(number)}".rstrip())
    return "\n".join(lines)


def _hex(number: np.floating) -> str:
    """Hexadecimal notation, exact: a longdouble as the sum of two doubles."""
    head = float(number)
    rest = float(number - type(number)(head)) if np.isfinite(number) else 0.0
    return head.hex() + (f" + {rest.hex()}" if rest else "")
