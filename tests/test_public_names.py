"""The public names stay what they are, whatever else is imported.

Importing a module for the first time makes it an attribute of its package, in the place of a function of that name. So
each name is used before and after all modules are imported.
"""

import subprocess
import sys

import pytest

import raytrace

CODE = """
import importlib, inspect, pkgutil, sys
import numpy as np
import raytrace

def refused(name, *args, **choices):
    try:
        getattr(raytrace, name)(*args, **choices)
    except raytrace.InputError:
        return
    raise AssertionError(f"{name} is not the function of that name")

size = (4, 3)
image = np.zeros((16, 16, 3))
USES = {
    "Checkerboard": lambda: raytrace.Checkerboard(),
    "Film": lambda: raytrace.Film(),
    "MatrixCamera": lambda: raytrace.MatrixCamera(np.eye(4), np.eye(4)),
    "OrthographicCamera": lambda: raytrace.OrthographicCamera(2.0),
    "PerspectiveCamera": lambda: raytrace.PerspectiveCamera(),
    "Plain": lambda: raytrace.Plain([1, 1, 1]),
    "Plane": lambda: raytrace.Plane(),
    "Scene": lambda: raytrace.Scene(),
    "Sky": lambda: raytrace.Sky(),
    "Spheres": lambda: raytrace.Spheres(),
    "Sun": lambda: raytrace.Sun(),
    "EngineFailure": lambda: raytrace.EngineFailure("line"),
    "InputError": lambda: raytrace.InputError("line"),
    "Certificate": lambda: isinstance(raytrace.certify("sphere", size), raytrace.Certificate) or 1 / 0,
    "Comparison": lambda: isinstance(raytrace.compare(image, image), raytrace.Comparison) or 1 / 0,
    "SunFit": lambda: inspect.isclass(raytrace.SunFit) or 1 / 0,
    "Verification": lambda: inspect.isclass(raytrace.Verification) or 1 / 0,
    "certify": lambda: raytrace.certify("sphere", size).size == size or 1 / 0,
    "check_scene": lambda: raytrace.check_scene(raytrace.Scene()),
    "compare": lambda: raytrace.compare(image, image).ssim.mean == 1 or 1 / 0,
    "fit_sun": lambda: refused("fit_sun", "nowhere.png", "sphere"),
    "load_scene": lambda: raytrace.load_scene("sphere"),
    "prepare": lambda: raytrace.prepare("sphere", size, backend="numpy")().shape == (3, 4, 3) or 1 / 0,
    "read_certificate": lambda: refused("read_certificate", "nowhere.exr"),
    "read_image": lambda: refused("read_image", "nowhere.png"),
    "render": lambda: raytrace.render("sphere", size, backend="numpy").shape == (3, 4, 3) or 1 / 0,
    "render_each": lambda: raytrace.render_each(["sphere"], size, backend="numpy")[0].shape == (3, 4, 3) or 1 / 0,
    "save_scene": lambda: raytrace.save_scene(raytrace.load_scene("sphere"), "a.toml"),
    "scenes": lambda: raytrace.scenes()["sphere"],
    "sun_angles": lambda: raytrace.sun_angles(np.array([0.0, 1.0, 0.0])),
    "sun_direction": lambda: raytrace.sun_direction(10.0, 20.0),
    "use_all_cores": lambda: raytrace.use_all_cores() is None or 1 / 0,
    "verify": lambda: raytrace.verify(np.zeros((3, 4, 3)), raytrace.certify("sphere", size)).inside in (True, False),
    "view": lambda: refused("view", "sphere", samples=3),
    "write_image": lambda: raytrace.write_image("a.png", image),
}
assert sorted(USES) == sorted(raytrace.__all__), set(USES) ^ set(raytrace.__all__)

def use_all():
    for name, use in USES.items():
        use()
        assert not inspect.ismodule(getattr(raytrace, name)), name

first = ORDER == "names first"
if first:
    use_all()
for module in pkgutil.walk_packages(raytrace.__path__, "raytrace."):
    if not module.name.endswith("__main__"):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as missing:  # an extra's package
            assert missing.name.split(".")[0] != "raytrace", missing
use_all()
from raytrace import *
assert callable(compare) and callable(certify) and callable(scenes)
"""


def used(order):
    done = subprocess.run([sys.executable, "-c", f"ORDER = {order!r}\n{CODE}"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_names_before_and_after_all_modules_are_imported():
    used("names first")


@pytest.mark.full
def test_names_once_all_modules_are_imported():
    used("modules first")


def test_every_public_name_is_there():
    for name in raytrace.__all__:
        assert getattr(raytrace, name) is not None
    assert sorted(dir(raytrace)) == sorted(raytrace.__all__)


def test_a_module_is_imported_when_it_is_used():
    code = (
        "import sys, raytrace\n"
        "assert not {'numpy', 'jax', 'pydantic'} & set(sys.modules)\n"
        "import raytrace.shader\n"
        "assert not {'jax', 'pydantic'} & set(sys.modules)\n"
        "raytrace.load_scene('checkerboard')\n"
        "assert not {'jax', 'colour', 'matplotlib', 'skimage', 'OpenImageIO', 'scipy'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
