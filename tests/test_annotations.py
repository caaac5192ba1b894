"""Annotations are true: they are checked at run time, in processes of their own, as that takes long."""

import subprocess
import sys

import pytest

CHECKED = """
import jaxtyping
jaxtyping.install_import_hook("raytrace", "beartype.beartype")
import numpy as np, raytrace
size = (16, 16)
scene = raytrace.load_scene("checkerboard", ["film.exposure=0.5"])
"""
#: By default.
CALLS = """
steps = raytrace.render(scene, size, backend="numpy", dtype="float64", output="steps")
raytrace.write_image("a.png", np.asarray(raytrace.render("skybox", (40, 20))))
certificate = raytrace.certify(scene, size, precision="glsl-highp")
assert raytrace.verify(steps["display"], certificate).inside
assert raytrace.compare(steps["display"], np.roll(steps["display"], 1, 0)).diagnosis is not None
raytrace.save_scene(scene, "a.toml")
from raytrace.language.glsl import Vec3
from raytrace.shader.light import shadow_ray
try:
    shadow_ray("ro", Vec3(1.0, 2.0, 3.0), None, None)
except jaxtyping.TypeCheckError:
    print("checked")
"""
#: In the full set.
MORE_CALLS = """
import jax
from dataclasses import replace
from raytrace.cli.groups import command
raytrace.render(scene, size, backend="numpy", antialias="edges")
# With as many spheres as tell where the sun is: more would take longer to compile.
spheres = raytrace.Spheres(*(part[[1, 2, 5]] for part in jax.tree.leaves(scene.spheres)))
few = replace(scene, spheres=spheres)
jax.grad(lambda few: raytrace.render(few, size).sum())(few)
raytrace.render("two-hundred-spheres", size)
image = np.round(255 * raytrace.render(few, (48, 24), backend="numpy")).astype(np.uint8)
print(raytrace.fit_sun(image, few))
for line in (
    "golden g --size 16x16 --scenes checkerboard", "check g --backend numpy", "conformance --scenes 2 --engine numpy",
    "export checkerboard --to glsl -o a.frag", "export checkerboard --to html -o a.html", "show checkerboard",
    "render checkerboard --size 16x16 --output steps -o a.exr", "pixel checkerboard 3 3 --size 16x16",
):
    name, *arguments = line.split()
    command(name).main(arguments, standalone_mode=False)
print("checked")
"""


@pytest.mark.parametrize("calls", [CALLS, pytest.param(MORE_CALLS, marks=pytest.mark.full)], ids=["few", "more"])
def test_annotations_are_true(calls):
    done = subprocess.run([sys.executable, "-c", CHECKED + calls], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("checked\n")
