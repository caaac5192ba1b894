"""The peers compute what they are compared for."""

import subprocess
import sys

import numpy as np
import pytest

import raytrace
from raytrace.errors import InputError
from raytrace.studies.bench.accuracy import reference
from raytrace.studies.bench.contenders import contenders, drawing_frame, drjit_frame, mitsuba_frame
from raytrace.studies.bench.crowds import crowd
from tests.engines import skip_unless_required

SIZE = 96, 54


@pytest.mark.parametrize("rectangles", [True, False])
def test_mitsubas_queries_are_this_scenes(rectangles):
    scene = raytrace.load_scene("checkerboard")
    try:
        frame, milliseconds = mitsuba_frame(scene, SIZE, rectangles)
    except InputError as missing:
        skip_unless_required(missing)
    assert milliseconds > 0
    t, blocked = (np.array(array).reshape(SIZE[::-1]) for array in frame())
    steps = raytrace.render(scene, SIZE, backend="numpy", dtype="float64", output="steps")
    # Its plane ends somewhere before the horizon.
    seen = (steps["index"] >= 0) & (steps["t"] < 1000)
    near = np.isclose(t, steps["t"], rtol=1e-3, atol=1e-3) & (np.isfinite(t) == (steps["index"] >= 0))
    assert near[seen].mean() > 0.99
    lit = seen & (steps["NdL"] > 0)
    assert (blocked == (steps["shadow"] == 0))[lit].mean() > 0.99


@pytest.mark.parametrize("name", ["checkerboard", "skybox", "two-tilted-planes"])
def test_the_kernel_of_drjit_is_the_same_picture(name):
    scene = raytrace.load_scene(name)
    try:
        frame = drjit_frame(scene, SIZE)
    except InputError as missing:
        skip_unless_required(missing)
    for _ in range(2):  # traced, and run again
        image = np.stack([np.array(plane) for plane in frame()], axis=-1).reshape(*SIZE[::-1], 3)
        errors = reference(scene, SIZE).errors(image)
        assert errors.over == 0
        assert errors.largest < 1e-3


def test_a_kernel_that_would_hold_too_many_spheres_is_refused():
    try:
        with pytest.raises(InputError, match="at most 32 spheres, found 33"):
            drjit_frame(crowd(33), SIZE)
    except InputError as missing:
        skip_unless_required(missing)


def test_opengl_draws_again_and_again():
    scene = raytrace.load_scene("checkerboard")
    try:
        frame = drawing_frame(scene, SIZE)
    except InputError as missing:
        skip_unless_required(missing)
    assert [frame() for _ in range(3)] == [None] * 3


@pytest.mark.full
def test_the_numba_loop_is_the_same_picture():
    try:
        import numba  # noqa: F401
    except ImportError:
        skip_unless_required(InputError("needs numba: pip install '.[bench]'"))
    # In a process of its own: Numba cannot compile what the suite's checks of annotations are wrapped around.
    code = (
        "import raytrace\n"
        "from raytrace.studies.bench.accuracy import reference\n"
        "from raytrace.studies.bench.peers.numba_loop import frame\n"
        "scene = raytrace.load_scene('checkerboard')\n"
        "exact = reference(scene, (96, 54))\n"
        "for fastmath in (False, True):\n"
        "    errors = exact.errors(frame(scene, (96, 54), fastmath)())\n"
        "    assert errors.over == 0 and errors.largest < 1e-3, errors\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_is_missing_is_told(monkeypatch):
    for module in ("mitsuba", "numba", "moderngl", "playwright"):
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setattr("raytrace.studies.bench.contenders.installed", lambda module: False)
    found, missing = contenders("checkerboard", (8, 8))
    assert {"jax float32 robust", "numpy longdouble", "jax float32 in one plain jit"} <= {one.name for one in found}
    assert len(missing) == 6
    assert all("pip install" in line for line in missing)


@pytest.mark.parametrize("name", ["orthographic", "lit-sphere"])
def test_scenes_that_a_peer_is_not_made_for(name):
    from raytrace.studies.bench.peers.numba_loop import frame

    with pytest.raises(InputError, match="numba"):
        frame(raytrace.load_scene(name), SIZE, False)
