"""JAX's own switches: with each of them a picture is drawn, or one line says why it is not."""

import os
import subprocess
import sys

import pytest

from tests.processes import COMMAND
from tests.scenes import some

VARIABLES = {
    "JAX_DEFAULT_DEVICE=cpu": "",
    "JAX_DISABLE_JIT=1": "",
    "JAX_ENABLE_X64=1": "",
    "JAX_DEFAULT_DEVICE=gpu": "jax: has no device with JAX_DEFAULT_DEVICE=gpu: ",
    "JAX_PLATFORMS=nonsense": "jax: has no device with JAX_PLATFORMS=nonsense: ",
    "JAX_PLATFORMS=cuda": "jax: has no device with JAX_PLATFORMS=cuda: ",
    "JAX_NUM_CPU_DEVICES=0": "jax: has no device with JAX_NUM_CPU_DEVICES=0: ",
    "JAX_NUM_CPU_DEVICES=x": "jax: Invalid value",
    "JAX_ENABLE_X64=maybe": "jax: invalid truth value",
}


@pytest.mark.parametrize(
    "variable", some(VARIABLES, "JAX_DISABLE_JIT=1", "JAX_PLATFORMS=cuda", "JAX_NUM_CPU_DEVICES=x")
)
def test_variables(variable, monkeypatch, tmp_path):
    monkeypatch.setenv(*variable.split("="))
    args = [*COMMAND, "render", "sphere", "--size", "16x16"]
    ended = subprocess.run(args, capture_output=True, text=True, cwd=tmp_path)
    told = VARIABLES[variable]
    if told:
        assert ended.returncode == 2
        assert ended.stderr.startswith(f"raytrace: {told}")
        assert ended.stderr.count("\n") == 1
    else:
        assert ended.returncode == 0, ended.stderr
    assert [path.name for path in tmp_path.iterdir()] == ([] if told else ["sphere.png"])


CONTEXTS = """
import os, sys, jax
jax.config.update("jax_num_cpu_devices", 2)
import jax.numpy as jnp, numpy as np, raytrace
from dataclasses import replace
from jax.sharding import AxisType, NamedSharding, PartitionSpec as P
scene, size = raytrace.load_scene("lit-sphere"), (16, 8)

def image(direction):
    return raytrace.render(replace(scene, sun=replace(scene.sun, direction=direction)), size)

suns = jnp.broadcast_to(jnp.float32(scene.sun.direction), (4, 3))
expected = raytrace.render(scene, size)
auto, explicit = (jax.make_mesh((2,), ("x",), axis_types=(kind,)) for kind in (AxisType.Auto, AxisType.Explicit))

def same(images):
    np.testing.assert_allclose(np.asarray(images), np.broadcast_to(expected, images.shape), atol=2e-5)

def refused(function, told):
    try:
        function()
    except raytrace.InputError as error:
        assert str(error).startswith(told) and len(str(error).splitlines()) == 1, error
    else:
        raise AssertionError("not refused")

"""
#: By default.
FEW = """
with jax.disable_jit():
    same(raytrace.render(scene, size))
with jax.set_mesh(auto):
    same(raytrace.render(scene, size))
refused(lambda: jax.jit(jax.shard_map(jax.vmap(image), mesh=auto, in_specs=P("x"), out_specs=P("x")))(suns), "jax: ren")
print("done", flush=True)
"""
#: In the full set.
MORE = """
for mesh in (auto, explicit):
    with jax.set_mesh(mesh):
        same(raytrace.render(scene, size))
        assert jnp.isfinite(jax.grad(lambda d: image(d).mean())(suns[0])).all()
with jax.disable_jit():
    same(raytrace.render(scene, size))
    same(image(suns[0]))
with jax.default_device(jax.devices()[1]):
    same(raytrace.render(scene, size))
same(jax.jit(jax.vmap(image))(jax.device_put(suns, NamedSharding(auto, P("x")))))
with jax.set_mesh(explicit):
    sharded = jax.device_put(suns, NamedSharding(explicit, P("x")))
    try:  # by JAX's version
        same(jax.jit(jax.vmap(image))(sharded))
    except raytrace.InputError as error:
        assert str(error).startswith("jax: render of arguments with"), error
mapped = dict(mesh=auto, in_specs=P("x"), out_specs=P("x"))
same(jax.jit(jax.shard_map(jax.vmap(image), check_vma=False, **mapped))(suns))
refused(lambda: jax.jit(jax.shard_map(jax.vmap(image), **mapped))(suns), "jax: render within shard_map: ")
print("done", flush=True)
"""

FORKED = """
import os, warnings, raytrace
warnings.simplefilter("ignore")
scene = raytrace.load_scene("sphere")
raytrace.render(scene, (8, 8))
if not os.fork():
    try:
        raytrace.render(scene, (8, 8))
    except raytrace.InputError as error:
        print(error, flush=True)
    os._exit(0)
os.wait()
"""


def ran(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=200)


@pytest.mark.parametrize("contexts", [FEW, pytest.param(MORE, marks=pytest.mark.full)], ids=["few", "more"])
def test_contexts(contexts):
    done = ran(CONTEXTS + contexts)
    assert done.stdout == "done\n", done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")
def test_a_forked_child_is_told():
    done = ran(FORKED)
    assert done.stdout.startswith("jax: this process was forked after JAX had begun"), done.stderr
    assert done.stdout.count("\n") == 1


#: What Windows, or macOS, has not.
ELSEWHERE = """
import os, signal, sys
for name in ("fcntl", "resource", "pwd", "grp", "termios"):
    sys.modules[name] = None
for module, names in (
    (os, ("getuid", "geteuid", "getgid", "sched_getaffinity", "pread", "posix_fallocate", "O_DIRECTORY", "O_NOFOLLOW")),
    (signal, ("SIGHUP", "SIGQUIT", "SIGUSR1", "SIGALRM", "setitimer", "pthread_kill", "pthread_sigmask")),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
kept = os.listdir
def hidden(path="."):
    if str(path).startswith("/proc"):
        raise FileNotFoundError(path)
    return kept(path)
os.listdir = hidden
import raytrace
raytrace.write_image("a.png", raytrace.render("checkerboard", (16, 9), backend="numpy"))
raytrace.render("sphere", (16, 9))
from raytrace.cli import run
sys.argv = ["raytrace", "render", "sphere", "--size", "16x9", "-o", "b.png"]
run()
"""


def test_other_systems(tmp_path):
    done = subprocess.run([sys.executable, "-c", ELSEWHERE], capture_output=True, text=True, cwd=tmp_path, timeout=200)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.png"]
