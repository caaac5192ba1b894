"""A scene as a web page: one file that asks for nothing else."""

import base64
import json
import re
from dataclasses import replace
from importlib import resources
from typing import Any

import numpy as np

from raytrace.export.legend import legend, with_step_colors
from raytrace.glsl import values_of, vertex_shader
from raytrace.glsl.bindings import bindings
from raytrace.glsl.choices import choices_of
from raytrace.glsl.shader import shader_text
from raytrace.scene.data import MatrixCamera, Scene
from raytrace.scene.document import document_of
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.scene.toml import scene_toml
from raytrace.shader.film import TONE_MAPPERS
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["html"]

_FILES = resources.files("raytrace.export") / "web"
_INLINED = re.compile(r'<link rel="stylesheet" href="(\w+\.css)">|<script src="(\w+\.js)"></script>')
_DATA = '<script type="application/json" id="scene">'


def html(scene: Scene, size: tuple[int, int], *, intersection: str = "textbook", data: str = "uniforms") -> str:
    """The page: the assignment's GLSL on WebGL2, in a canvas of the shape of `size`, with controls.

    Its shaders take the scene as uniforms whatever `data` says.

    Raises:
        InputError: the scene has what GLSL or a scene file cannot have.
    """
    document = document_of(scene)
    pivot = _pivot(scene)
    contents = {
        "size": size,
        "toml": scene_toml(scene),
        **{table: document[table] for table in ("camera", "sun", "film")},
        "pivot": pivot.tolist(),
        **_drawn(uniforms_of(scene, size[0] / size[1]), program_of(scene, intersection), pivot),
    }
    # Without a "<" nothing in it can end the script that it stands in.
    text = json.dumps(contents, separators=(",", ":")).replace("<", "\\u003c")
    return _INLINED.sub(_inlined, _file("page.html")).replace(_DATA, _DATA + text)


def _drawn(uniforms: Uniforms, program: Program, pivot: np.ndarray) -> dict[str, Any]:
    """Shaders, one for each tone mapper, and what they are given; what the steps' colours mean."""
    # The exposure is a uniform even where it is 0.
    if uniforms.film.exposure is None:
        uniforms = uniforms._replace(film=uniforms.film._replace(exposure=np.float64(1)))
    values = values_of(uniforms)
    distance = float(np.linalg.norm(values["camPos"] - pivot)) or 1.0
    fragments = {}
    for name in TONE_MAPPERS:
        choices = choices_of(uniforms, replace(program, tone_mapper=name), data="uniforms", output="steps")
        fragments[name] = with_step_colors(shader_text(choices, values), distance)
    flat, textures = bindings(choices, values)
    return {
        "vertex": vertex_shader(),
        "fragments": fragments,
        "uniforms": {name: np.ravel(value).tolist() for name, value in flat.items()},
        "textures": {name: _texture(texels) for name, texels in textures.items()},
        "steps": legend(distance),
    }


def _pivot(scene: Scene) -> np.ndarray:
    """The point that the camera orbits: its target; of one given by matrices, the middle of the spheres."""
    camera = scene.camera
    if not isinstance(camera, MatrixCamera):
        return camera.target
    if scene.spheres.radius.size:
        return np.median(scene.spheres.center, axis=0)  # the mean could lie in the centre of a huge one
    return camera.view_to_world[:3, 3] - 5 * camera.view_to_world[:3, 2]


def _texture(texels: np.ndarray) -> dict[str, Any]:
    height, width, _ = texels.shape
    return {"width": width, "height": height, "texels": base64.b64encode(np.float32(texels).tobytes()).decode()}


def _inlined(match: re.Match) -> str:
    style, script = match.groups()
    return f"<style>\n{_file(style)}</style>" if style else f"<script>\n{_file(script)}</script>"


def _file(name: str) -> str:
    return (_FILES / name).read_text(encoding="utf-8")
