"""A program for each core draws what one program for all of them draws."""

import os
import threading

import jax
import numpy as np
import pytest

import raytrace
from raytrace.backends.jax import replicas
from raytrace.backends.jax.devices import one_device
from raytrace.backends.jax.renderer import OPTIONS, _compiled
from tests.scenes import some

pytestmark = pytest.mark.skipif(not replicas.possible(one_device()), reason="needs Linux, and CPUs alone")
SIZE = (40, 24)


@pytest.mark.parametrize(
    ("name", "output"),
    some(
        [(name, output) for name in raytrace.scenes() for output in ("linear", "steps")],
        ("lit-sphere", "steps"),
        ("skybox", "linear"),
    ),
)
def test_the_bits_are_those_of_one_program(name, output, monkeypatch):
    scene = raytrace.load_scene(name)
    monkeypatch.setenv("RAYTRACE_CACHE", "off")
    images = []
    for possible in (replicas.possible, lambda devices: False):
        monkeypatch.setattr("raytrace.backends.jax.renderer.possible", possible)
        _compiled.cache_clear()
        images.append(raytrace.prepare(scene, SIZE, output=output)())
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
    program = replicas.Replicas(replicas.compiled_for_a_core(drawn, OPTIONS, *given, number), devices, ("b", "a"))
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
