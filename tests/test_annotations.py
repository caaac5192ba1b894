"""Annotations are true: one example here, of calls to many parts of the package; all tests in the full set."""

import subprocess
import sys

CODE = """
import jaxtyping
jaxtyping.install_import_hook("raytrace", "beartype.beartype")
import numpy as np, raytrace
size = (16, 16)
scene = raytrace.load_scene("checkerboard", ["film.exposure=0.5"])
steps = raytrace.render(scene, size, backend="numpy", dtype="float64", output="steps")
image = np.asarray(raytrace.render("skybox", (40, 20)))
raytrace.write_image("a.png", image)
certificate = raytrace.certify(scene, size, precision="glsl-highp")
assert raytrace.verify(steps["display"], certificate).inside
assert raytrace.compare(steps["display"], np.roll(steps["display"], 1, 0)).diagnosis is not None
raytrace.save_scene(scene, "a.toml")
from raytrace.shader.glsl import Vec3, dot
from raytrace.shader.light import shadow_ray
try:
    shadow_ray("ro", Vec3(1.0, 2.0, 3.0), None, None)
except jaxtyping.TypeCheckError:
    print("checked")
"""


def test_annotations_are_checked_where_it_is_asked_for():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "checked\n"
