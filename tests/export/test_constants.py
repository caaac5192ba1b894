"""A scene's numbers in other languages: read back, they are the shader's float32."""

import re
import shutil
import subprocess

import numpy as np
import pytest

import raytrace
from raytrace.export import EXPORTS
from raytrace.glsl import values_of
from raytrace.scene.to_uniforms import uniforms_of
from tests.scenes import some

SIZE = (160, 90)


def numbers(text):
    """Each constant's name and its numbers."""
    found = re.findall(r"(?:\bfloat|const(?! float)) (\w+)[^=]*= (.*);", text)
    return {name: np.float32(re.findall(r"(?<![\w<])-?\d+\.\d*(?:e[-+]?\d+)?", value)) for name, value in found}


@pytest.mark.parametrize(
    "name", some(raytrace.scenes(), "checkerboard", "two-tilted-planes", "non-default-film", "skybox")
)
@pytest.mark.parametrize("to", ["header", "wgsl-constants"])
def test_they_are_the_shaders_float32(to, name):
    scene = raytrace.load_scene(name)
    found, values = numbers(EXPORTS[to](scene, SIZE)), values_of(uniforms_of(scene, SIZE[0] / SIZE[1]))
    for key, value in values.items():
        if not isinstance(value, list):
            np.testing.assert_array_equal(found[key], np.ravel(np.float32(value)))
    spheres = [] if not values["spheres"] else np.ravel(np.float32([each["center"] for each in values["spheres"]]))
    np.testing.assert_array_equal(found.get("sphereCenter", []), spheres)
    normals = [] if not values["planes"] else np.ravel(np.float32([each["normal"] for each in values["planes"]]))
    np.testing.assert_array_equal(found.get("planeNormal", []), normals)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler: apt-get install gcc")
def test_a_c_compiler_reads_the_same_numbers(tmp_path):
    scene = raytrace.load_scene("checkerboard", ["sun.color=[1e-9,123456.789,0.1]"])
    (tmp_path / "scene.h").write_text(EXPORTS["header"](scene, SIZE))
    (tmp_path / "main.c").write_text(
        '#include <stdio.h>\n#include "scene.h"\n'
        'int main(void) { for (int i = 0; i < sphereCount; ++i) printf("%a\\n", sphereRadius[i]);\n'
        'for (int i = 0; i < 3; ++i) printf("%a\\n", sunColor[i]); return imageWidth != 160; }\n'
    )
    subprocess.run(["cc", "-Wall", "-Wno-unused", "-o", tmp_path / "main", tmp_path / "main.c"], check=True)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout.split()
    expected = [*np.float32(scene.spheres.radius), *np.float32(scene.sun.color)]
    assert list(map(float.fromhex, printed)) == expected


def test_arrays_of_wgsl_have_their_types():
    text = EXPORTS["wgsl-constants"](raytrace.load_scene("checkerboard"), SIZE)
    for line in (
        "const camPos: vec3<f32> = vec3<f32>(0.0, 0.5, 2.0);",
        "const imageWidth: u32 = 160u;",
        "const sphereCount: u32 = 6u;",
        "const sphereRadius: array<f32, 6> = array<f32, 6>(1.5, 0.6, 0.8, 0.2, 0.2, 0.3);",
        "const planeTileSize: array<f32, 1> = array<f32, 1>(0.5);",
    ):
        assert line in text.splitlines()
    assert re.search(r"const viewToWorld: mat4x4<f32> = mat4x4<f32>\(1\.0,", text)
    assert re.search(r"const sphereCenter: array<vec3<f32>, 6> = array<vec3<f32>, 6>\(vec3<f32>\(-2\.0,", text)
