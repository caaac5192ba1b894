"""A scene as the fragment shader of the assignment."""

import textwrap

import numpy as np

from raytrace.errors import InputError
from raytrace.glsl import fragment_shader
from raytrace.glsl.choices import CONSTANT_VECTORS
from raytrace.scene.data import MatrixCamera, OrthographicCamera, PerspectiveCamera, Scene
from raytrace.scene.to_uniforms import program_of, uniforms_of

__all__ = ["glsl", "shaderlabweb"]


def glsl(scene: Scene, size: tuple[int, int], *, intersection: str = "textbook", data: str = "constants") -> str:
    """The fragment shader, GLSL ES 3.00, with the scene's data (not the camera) as "constants" or as "uniforms".

    Raises:
        InputError: the scene has what GLSL cannot have.
    """
    return fragment_shader(uniforms_of(scene, size[0] / size[1]), program_of(scene, intersection), data=data)


def shaderlabweb(
    scene: Scene, size: tuple[int, int], *, intersection: str = "textbook", data: str = "constants"
) -> str:
    """The fragment shader with a note on top of where it goes in ShaderLabWeb, and what to attach and to set there.

    Raises:
        InputError: the scene has what GLSL cannot have, or needs a texture that ShaderLabWeb is not given.
    """
    text = glsl(scene, size, intersection=intersection, data=data)
    if "sphereTexture" in text:
        most = CONSTANT_VECTORS // 3
        raise InputError(f"spheres: ShaderLabWeb takes at most {most} as constants, found {len(scene.spheres.radius)}")
    version, rest = text.split("\n", 1)
    note = [
        "Paste this over the fragment shader of the pass that renders to a quad (R2T). Under 'Uniforms' attach",
        *_attached(rest),
        *_camera(scene.camera),
    ]
    lines = [line for part in note for line in textwrap.wrap(part, 112, subsequent_indent="    ")]
    return "\n".join([version, *(f"// {line}" for line in lines), rest])


def _attached(text: str) -> list[str]:
    """The lines that the declarations of the camera's uniforms stand on, as a list."""
    pairs = [line.removeprefix("uniform ").split("; // ") for line in text.splitlines() if line.startswith("uniform ")]
    return [f"    {pair[0].split()[1]}: {pair[1]}" for pair in pairs if len(pair) == 2]


def _camera(camera: PerspectiveCamera | OrthographicCamera | MatrixCamera) -> list[str]:
    if isinstance(camera, MatrixCamera):
        return ["The scene's camera is given by its matrices; set ShaderLabWeb's as you like."]
    camera_line = f"and set the camera to position {_numbers(camera.position)}, target {_numbers(camera.target)}, "
    camera_line += f"near {_numbers(camera.near)}, far {_numbers(camera.far)}, "
    if isinstance(camera, PerspectiveCamera):
        camera_line += f"projection Perspective, FOV {_numbers(camera.field_of_view)}."
    else:
        camera_line += "projection Orthographic (an extension here)."
    level = np.array_equal(np.asarray(camera.up) / np.max(np.abs(camera.up)), [0, 1, 0])
    return [camera_line] if level else [camera_line, "ShaderLabWeb's up is always (0, 1, 0): this camera's is another."]


def _numbers(value: np.ndarray) -> str:
    return f"({', '.join(f'{x:g}' for x in value)})" if np.ndim(value) else f"{float(value):g}"
