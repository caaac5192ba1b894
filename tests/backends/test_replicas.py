"""A program for each core draws what one program for all of them draws."""

import os
import threading

import jax
import numpy as np
import pytest

import raytrace
from raytrace.backends.jax import Staged, replicas
from raytrace.backends.jax.devices import one_device
from raytrace.backends.jax.renderer import FEW, OPTIONS, _compiled, _kept
from raytrace.rendering import Options, Rendering
from tests.scenes import some

pytestmark = pytest.mark.skipif(not replicas.possible(one_device()), reason="needs Linux, and CPUs alone")
SIZE = (40, 24)


@pytest.mark.parametrize(
    ("name", "output"),
    some(
        [("lit-sphere", "steps"), *((name, "linear") for name in raytrace.scenes())],
        ("skybox", "linear"),
    ),
)
def test_the_bits_are_those_of_one_program(name, output, monkeypatch):
    assert_same_bits(raytrace.load_scene(name), output, monkeypatch)


@pytest.mark.full
def test_what_is_prepared_of_many_spheres_is_given_too(monkeypatch):
    monkeypatch.setitem(FEW, Staged, 0)
    _kept.cache_clear()
    assert_same_bits(raytrace.load_scene("lit-sphere"), "linear", monkeypatch)
    _kept.cache_clear()


def assert_same_bits(scene, output, monkeypatch):
    monkeypatch.setenv("RAYTRACE_CACHE", "off")
    images = []
    for possible, kind in ((replicas.possible, replicas.Replicas), (lambda devices: False, jax.stages.Compiled)):
        monkeypatch.setattr("raytrace.backends.jax.renderer.possible", possible)
        _compiled.cache_clear()
        # Made anew: a renderer that is kept would draw by the program that it has.
        rendering = Rendering(Options(scene, SIZE, output=output))
        assert isinstance(rendering.renderer.executable(SIZE[1]), kind)
        images.append(rendering.whole())
    _compiled.cache_clear()
    one, other = images
    jax.tree.map(np.testing.assert_array_equal, one, other)
    assert jax.tree.map(lambda image: image.sharding, one) == jax.tree.map(lambda image: image.sharding, other)


def test_every_array_is_given_whether_it_is_used_or_not():
    devices = one_device()

    def drawn(used, unused, number):
        return {"b": used[:, None] + number[0], "a": 2 * used[:, None]}

    given = [jax.ShapeDtypeStruct((3,), np.float32), [jax.ShapeDtypeStruct((5,), np.int32)]]
    number = jax.ShapeDtypeStruct((1,), np.int32)
    content = replicas.compiled_for_a_core(drawn, OPTIONS, *given, number)
    program = replicas.Replicas(content, ("b", "a"), list(devices.devices.flat))
    x, rest = jax.device_put((np.arange(3, dtype=np.float32), np.zeros(5, np.int32)), devices.devices.flat[0])
    found = program(x, [rest])
    np.testing.assert_array_equal(found["a"][:, 0], [0, 2, 4])
    np.testing.assert_array_equal(found["b"][:, 0], [0, 1, 2])
    assert program.cost_analysis()["flops"] > 0


def test_where_no_thread_may_be_confined_one_program_is_for_all(monkeypatch):
    def refused(*_):
        raise PermissionError

    expected = np.asarray(raytrace.render("skybox", SIZE))
    replicas._compiler.cache_clear()
    _compiled.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(os, "sched_setaffinity", refused)
        assert not replicas.possible(one_device())
        np.testing.assert_array_equal(raytrace.prepare("skybox", SIZE, skip=False)(), expected)
    replicas._compiler.cache_clear()
    _compiled.cache_clear()
    assert replicas.possible(one_device())


def test_nobody_else_is_confined_to_a_core():
    before = os.sched_getaffinity(0)
    replicas._compiler.cache_clear()
    replicas._compiler()
    found = []
    thread = threading.Thread(target=lambda: found.append(os.sched_getaffinity(0)))
    thread.start()
    thread.join()
    assert found == [before]
    assert os.sched_getaffinity(0) == before
