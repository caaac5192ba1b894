"""What stands above the functions: inputs, uniforms, structs and the scene's numbers."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from raytrace.glsl.choices import Choices
from raytrace.glsl.numbers import number, vector

__all__ = ["declarations", "sphere_texture", "struct_values"]

#: Spheres in a row of the texture that holds them: two texels each.
TEXTURE_SPHERES = 512

#: The camera's uniforms and, in ShaderLabWeb, the value to attach to each.
CAMERA = {
    "camPos": ("vec3", "Camera Position"),
    "viewToWorld": ("mat4", "Inverse View Matrix"),
    "ndcToView": ("mat4", "Inverse Projection Matrix"),
}
_TYPES = {0: "float", 3: "vec3", 9: "mat3", 16: "mat4"}

_BRACKETS = {"Sphere": "// Departure: the printed text has lost the brackets of Sphere[](...).\n", "Plane": ""}
_TEXTURE = """\
// Departure: more spheres than {limit} allow. They stand in a texture of floats, {row} in a row, two texels each:
// center and radius, then color.
uniform highp sampler2D sphereTexture;
const int sphereCount = {count};

Sphere sphereAt(int i){{
    ivec2 texel = ivec2(2*(i % {row}), i / {row});
    vec4 centerAndRadius = texelFetch(sphereTexture, texel, 0);
    vec3 color = texelFetch(sphereTexture, texel + ivec2(1, 0), 0).rgb;
    return Sphere(centerAndRadius.xyz, centerAndRadius.w, color);
}}
"""


def declarations(choices: Choices, values: dict[str, Any]) -> Iterator[str]:
    """The paragraphs above the functions; `values` are those of `values_of`."""
    yield (
        "precision highp float;\n"
        "precision highp int;\n"
        "\n"
        "in vec2 fragmentTextureCoordinates; // of the pixel's centre, from 0 to 1\n"
        "out vec4 fragColor;\n"
    )
    yield "// The camera. In ShaderLabWeb attach the value that the comment names.\n" + "".join(
        f"uniform {kind} {name}; // {attached}\n"
        for name, (kind, attached) in CAMERA.items()
        if not (choices.orthographic and name == "camPos")
    )
    scalars = {name: value for name, value in values.items() if isinstance(value, np.ndarray) and name not in CAMERA}
    yield "".join(_declared(name, value, choices) for name, value in scalars.items())
    if choices.output == "steps":
        yield _STEPS
    if choices.spheres:
        yield _struct("Sphere", values["spheres"][0], choices)
        yield _sphere_array(choices, values["spheres"])
    if choices.planes:
        yield _struct("Plane", values["planes"][0], choices)
        yield _array("Plane", "planes", values["planes"], choices)
    if choices.shadow_planes and not choices.all_planes_cast:
        yield "// Extension: those of the planes that cast shadows.\n" + _array(
            "Plane", "shadowPlanes", values["shadowPlanes"], choices
        )
    if choices.spheres or choices.planes:
        yield (
            "// Departure: GLSL ES 3.00 does not define 1./0. (section 4.5.1); the largest float serves as well.\n"
            "const float infinity = 3.402823466e38;\n"
        )


_STEPS = """\
// What the program comes by on its way to a pixel's colour; shownStep counts these, then the linear and the display
// colour.
struct Steps{
    vec2 pixelNdc;
    vec3 rd;
    float t;
    int index; // spheres first, then planes; -1: the sky
    vec3 hitPoint;
    vec3 N;
    float NdL;
    float NdSky;
    float shadow;
    vec3 albedo;
};
Steps steps;
uniform int shownStep;
"""


def sphere_texture(spheres: list[dict[str, np.ndarray]]) -> np.ndarray:
    """The texture that ``sphereAt`` reads: float32 (rows, 2 * TEXTURE_SPHERES, 4)."""
    rows = -(-len(spheres) // TEXTURE_SPHERES)
    texels = np.zeros((rows * TEXTURE_SPHERES, 2, 4), np.float32)
    texels[: len(spheres), 0, :3] = [sphere["center"] for sphere in spheres]
    texels[: len(spheres), 0, 3] = [sphere["radius"] for sphere in spheres]
    texels[: len(spheres), 1, :3] = [sphere["color"] for sphere in spheres]
    return texels.reshape(rows, 2 * TEXTURE_SPHERES, 4)


def struct_values(struct: str, value: dict[str, np.ndarray], choices: Choices) -> dict[str, np.ndarray]:
    """The fields that the text's ``struct Sphere`` or ``struct Plane`` has, in its order."""
    if struct == "Sphere":
        return value
    common = {name: value[name] for name in ("point", "normal")}
    if not choices.patterned:
        return common | {"color": value["evenColor"]}
    colors = () if choices.printed_checkerboard else ("evenColor", "oddColor", "lineColor")
    return common | {name: value[name] for name in ("tileSize", *colors)}


def _struct(struct: str, value: dict[str, np.ndarray], choices: Choices) -> str:
    fields = struct_values(struct, value, choices)
    return f"struct {struct}{{\n" + "".join(f"    {_type(x)} {name};\n" for name, x in fields.items()) + "};\n"


def _type(value: np.ndarray) -> str:
    return _TYPES[value.size if value.ndim else 0]


def _declared(name: str, value: np.ndarray, choices: Choices) -> str:
    kind = _type(value)
    if choices.data == "uniforms":
        return f"uniform {kind} {name};\n"
    return f"const {kind} {name} = {_literal(value)};\n"


def _literal(value: np.ndarray) -> str:
    if value.ndim == 0:
        return number(value)
    return vector(value) if value.size == 3 else f"mat3({', '.join(map(number, value))})"


def _sphere_array(choices: Choices, spheres: list[dict[str, np.ndarray]]) -> str:
    if choices.spheres_in_texture:
        return _TEXTURE.format(limit=choices.data, row=TEXTURE_SPHERES, count=choices.spheres)
    return _array("Sphere", "spheres", spheres, choices)


def _array(struct: str, name: str, items: list[dict[str, np.ndarray]], choices: Choices) -> str:
    if choices.data == "uniforms":
        return f"uniform {struct} {name}[{len(items)}];\n"
    texts = [
        f"    {struct}({', '.join(map(_literal, struct_values(struct, item, choices).values()))})" for item in items
    ]
    return f"{_BRACKETS[struct]}const {struct} {name}[] = {struct}[](\n" + ",\n".join(texts) + "\n);\n"
