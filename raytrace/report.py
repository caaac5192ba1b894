"""What the shader is given and what it does at a pixel, as text for somebody who debugs another renderer."""

from typing import Any

import numpy as np

from raytrace.rendering import Rendering
from raytrace.scene.data import Scene
from raytrace.shader.glsl import Mat4, Vec3
from raytrace.shader.main import COMPONENTS
from raytrace.uniforms import uniforms_of

__all__ = ["pixel_report", "uniforms_report"]


def uniforms_report(scene: Scene, size: tuple[int, int]) -> dict[str, Any]:
    """The uniforms of `scene`, by the assignment's names, for JSON.

    Every number is a dict: "value" in double, as it was computed; "float32", what it is rounded to and rendered with;
    that number's hexadecimal notation ("hex", as in C and Python) and its 32 bits ("bits"). Vectors are lists,
    matrices lists of 16 in GLSL's order, column by column.
    """
    uniforms = uniforms_of(scene, size[0] / size[1])
    camera, sun, sky, film = uniforms.camera, uniforms.sun, uniforms.sky, uniforms.film
    return {
        "camPos": _vector(camera.view_to_world.w.xyz),
        "ndcToView": _matrix(camera.ndc_to_view),
        "viewToWorld": _matrix(camera.view_to_world),
        "sunColor": _vector(sun.color),
        "sunDirection": _vector(sun.direction),
        "skyColorLow": _vector(sky.low),
        "skyColorHigh": _vector(sky.high),
        "voidColor": _vector(sky.void),
        "spheres": _structs(uniforms.spheres),
        "planes": _structs(uniforms.planes),
        "lighting": scene.lighting,
        "exposureFactor": None if film.exposure is None else _number(film.exposure),
        "whiteBalance": None if film.white_balance is None else [_vector(column) for column in film.white_balance],
        "toneMapper": scene.film.tone_mapper,
        "transfer": scene.film.transfer,
    }


def _number(x: Any) -> dict[str, Any]:
    rounded = np.float32(x)
    return {
        "value": float(x),
        "float32": float(rounded),
        "hex": float(rounded).hex(),
        "bits": f"0x{rounded.view(np.uint32):08x}",
    }


def _vector(vector: tuple) -> list:
    return [_number(component) for component in vector]


def _matrix(matrix: Mat4) -> list:
    return [_number(component) for column in matrix for component in column]


_STRUCT_NAMES = {"tile_size": "tileSize", "even": "evenColor", "odd": "oddColor", "line": "lineColor"}


def _structs(structs: Any) -> list[dict[str, Any]]:
    """One dict a struct, of a struct of arrays."""
    if structs is None:
        return []

    def item(array: Any, i: int) -> Any:
        return _vector(Vec3(*(component[i] for component in array))) if isinstance(array, Vec3) else _number(array[i])

    return [
        {_STRUCT_NAMES.get(name, name): item(array, i) for name, array in structs._asdict().items()}
        for i in range(len(structs[0].x))
    ]


#: Each step's line in the assignment; the surface's depend on what was hit.
_GLSL = {
    "pixelNdc": "vec2 pixelNdc = 2. * fragmentTextureCoordinates - 1.;",
    "rd": "vec3 rd = normalize(mat3(viewToWorld) * pixelViewSpace);",
    "t": "float t = closestSphereIntersect(ro,rd,sphereIndex); // then the planes",
    "index": "out int sphereIndex // planes are counted after the spheres",
    "hitPoint": "vec3 hitPoint = ro + t*rd;",
    "NdL": "float NdL = max(dot(N,L),0.0);",
    "NdSky": "float NdSky = clamp(0.5*N.y+0.5, 0.0, 1.0 );",
    "shadow": "float shadow = shadowRay(point + 1e-3*N, L);",
    "display": "fragColor = vec4(tonemapAndGammaCorrect(col), 1.);",
}
_GLSL_SKY = {"linear": "col = backgroundColor(rd);"}
_GLSL_SPHERE = {
    "N": "vec3 normal = normalize(hitPoint-spheres[sphereIndex].center);",
    "albedo": "spheres[sphereIndex].color",
    "linear": "col = light*spheres[sphereIndex].color;",
}
_GLSL_PLANE = {
    "N": "// the plane's normal",
    "albedo": "checkerboard(hitPoint, tileSize)",
    "linear": "col = light*checkerboard(hitPoint, tileSize);",
}
_SURFACE = ("hitPoint", "N", "NdL", "NdSky", "shadow", "albedo")


def pixel_report(rendering: Rendering, x: int, y: int) -> str:
    """Every step at pixel (x, y) beside its line of GLSL: each number in decimal and in hexadecimal notation.

    `rendering` is one of the output "steps".

    Raises:
        InputError: there is no such pixel.
    """
    steps = rendering.pixel(x, y)
    index = int(steps["index"])
    spheres = len(rendering.scene.spheres.radius)
    glsl = _GLSL | (_GLSL_SKY if index < 0 else _GLSL_SPHERE if index < spheres else _GLSL_PLANE)
    seen = "sky" if index < 0 else f"sphere {index}" if index < spheres else f"plane {index - spheres}"
    width, height, _ = rendering.frame
    lines = [f"pixel {x} {y} of {width}x{height}, {rendering.backend} {rendering.dtype}: {seen}"]
    for name in COMPONENTS:
        if index < 0 and name in _SURFACE:
            continue
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
