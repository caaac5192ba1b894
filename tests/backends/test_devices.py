"""One device, eight, and two processes give the same bits."""

import json
import os
import re
import socket
import subprocess
import sys
import time
from contextlib import ExitStack

import numpy as np
import pytest

import raytrace
from raytrace.cores import cores
from tests.processes import COMMAND, command, peak_memory, started
from tests.scenes import some

SIZE = "200x120"
RENDER = (
    "import sys, jax, numpy as np, raytrace\n"
    "image = raytrace.render(sys.argv[1], (200, 120))\n"
    "assert len(image.sharding.device_set) == int(sys.argv[3]), image.sharding\n"
    "np.save(sys.argv[2], image)\n"
)


def drawn(tmp_path, scene, devices, flags=""):
    out = tmp_path / f"{devices}.npy"
    env = os.environ | {"XLA_FLAGS": flags, "RAYTRACE_CACHE": "off"}
    subprocess.run([sys.executable, "-c", RENDER, scene, str(out), str(devices)], check=True, env=env)
    return np.load(out)


@pytest.mark.parametrize("scene", some(["skybox", "sphere", "checkerboard", "two-hundred-spheres"], "skybox"))
def test_eight_devices(tmp_path, scene):
    one, eight = (drawn(tmp_path, scene, n, f"--xla_force_host_platform_device_count={n}") for n in (1, 8))
    np.testing.assert_array_equal(one, eight)


def devices_and_log(tmp_path, calls, devices):
    """What is logged of a rendering after such calls, by so many devices."""
    code = RENDER.replace("image =", f"{calls}; image =")
    command = [sys.executable, "-c", code, "skybox", str(tmp_path / "a.npy"), str(devices)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stderr


@pytest.mark.parametrize(
    ("before", "devices", "told"),
    some(
        [
            ("", cores(), ""),
            ("jax.devices(); ", 1, "JAX is initialised; its device count can no longer change\n"),
            ("jax.config.update('jax_num_cpu_devices', 1); ", 1, ""),
        ],
        ("", cores(), ""),
        ("jax.devices(); ", 1, "JAX is initialised; its device count can no longer change\n"),
    ),
)
def test_every_core_has_a_device_if_that_is_asked_for(tmp_path, before, devices, told):
    said = devices_and_log(tmp_path, f"{before}raytrace.use_all_cores()", devices)
    assert said.startswith(told) if told else not said


@pytest.mark.skipif(cores() == 1, reason="there is only one core")
def test_a_library_user_is_told_once_of_cores_that_do_not_draw(tmp_path):
    told = devices_and_log(tmp_path, "raytrace.render('skybox', (8, 8))", 1)
    assert told.count("\n") == 1
    assert "call raytrace.use_all_cores()" in told


@pytest.mark.full
def test_the_command_uses_all_cores():
    done = command("bench", "--roofline", "--size", "16x16", "--runs", "1")
    assert re.match(rf"JAX \S+ on {cores()} CPU devices; {cores()} cores\n", done.stdout)


@pytest.mark.full
def test_a_width_that_the_devices_cannot_share(tmp_path):
    code = (
        "import sys, numpy as np, raytrace\n"
        "np.save(sys.argv[1], raytrace.render('lit-sphere', (101, 40)))\n"
        "np.save(sys.argv[2], raytrace.render('lit-sphere', (101, 40), skip=False))\n"
    )
    images = []
    for n in (1, 3):
        paths = [str(tmp_path / f"{n}-{name}.npy") for name in "ab"]
        env = os.environ | {"XLA_FLAGS": f"--xla_force_host_platform_device_count={n}"}
        subprocess.run([sys.executable, "-c", code, *paths], check=True, env=env)
        images += [np.load(path) for path in paths]
    for image in images[1:]:
        assert image.shape == (40, 101, 3)
        np.testing.assert_array_equal(image, images[0])


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def test_two_processes_render_one_image(tmp_path):
    alone, together = tmp_path / "alone.exr", tmp_path / "together.exr"
    command("render", "skybox", "--size", SIZE, "-o", alone)
    joined = ["--coordinator", f"127.0.0.1:{free_port()}", "--hosts", "2"]
    args = [*COMMAND, "render", "skybox", "--size", SIZE, "-o", str(together), *joined, "--process-id"]
    with ExitStack() as stack:
        processes = [stack.enter_context(started([*args, str(i)], stdout=subprocess.PIPE, text=True)) for i in range(2)]
        told = [process.communicate(timeout=240)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    assert "together.exr" in told[0]
    assert "together.exr" not in told[1]
    np.testing.assert_array_equal(raytrace.read_image(alone), raytrace.read_image(together))


@pytest.mark.parametrize(
    ("coordinator", "process_id", "told"),
    [
        ("127.0.0.1:{free}", 0, "1 of 2 processes did not come"),
        ("127.0.0.1:{free}", 1, "process 1 of 2 could not join"),
        ("127.0.0.1:{taken}", 0, "cannot be used: address already in use"),
        ("127.0.0.1:{taken}", 1, "process 1 of 2 could not join"),
        ("no-such-host.invalid:{free}", 1, "is no host's name"),
    ],
)
def test_who_does_not_come_is_one_line(tmp_path, coordinator, process_id, told):
    with socket.create_server(("", 0)) as taken:
        coordinator = coordinator.format(free=free_port(), taken=taken.getsockname()[1])
        args = ["--coordinator", coordinator, "--hosts", "2", "--process-id", process_id, "--wait", "1"]
        begun = time.monotonic()
        ended = command("render", "skybox", *args, cwd=tmp_path)
    assert time.monotonic() - begun < 60
    assert ended.returncode == 1, ended.stderr
    assert told in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("ended", some([0, 1], 1))
def test_one_that_is_ended_ends_the_others(tmp_path, ended):
    joined = ["--coordinator", f"127.0.0.1:{free_port()}", "--hosts", "2", "--size", "16000x16000"]
    args = [*COMMAND, "render", "checkerboard", "-o", str(tmp_path / "a.exr"), *joined, "--process-id"]
    with ExitStack() as stack:
        processes = [stack.enter_context(started([*args, str(i)], stderr=subprocess.PIPE, text=True)) for i in range(2)]
        while not list(tmp_path.iterdir()):  # its first rows are drawn
            assert all(process.poll() is None for process in processes)
            time.sleep(0.1)
        processes[ended].terminate()
        said = [process.communicate(timeout=60)[1] for process in processes]
    assert [process.returncode for process in processes] == [143 if i == ended else 1 for i in range(2)]
    assert said[1 - ended].splitlines()[-1] == f"raytrace: process {ended} of 2 has ended"
    assert not list(tmp_path.iterdir())


#: Arguments of the command, and what it says of them.
BAD_INPUT = [
    (["--hosts", "2"], "give all three"),
    (["--coordinator", "localhost:1", "--hosts", "2", "--process-id", "2"], "must be from 0 to 1"),
    (["--coordinator", "localhost", "--hosts", "2", "--process-id", "0"], "must be HOST:PORT"),
    (["--coordinator", "localhost:99999", "--hosts", "2", "--process-id", "0"], "must be HOST:PORT"),
    (["--coordinator", "localhost:1", "--hosts", "1000000000", "--process-id", "0"], "must be from 1 to 4096"),
    (["--coordinator", "localhost:1", "--hosts", "2", "--process-id", "0", "--wait", "inf"], "wait: must be"),
    (["--cluster"], "no scheduler"),
    (["--cluster", "--backend", "numpy"], "only jax"),
]


@pytest.mark.parametrize(("options", "message"), BAD_INPUT)
def test_mistakes_are_one_line(tmp_path, options, message):
    ended = command("render", *options, cwd=tmp_path)
    assert ended.returncode == 2, ended.stderr
    assert message in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


# Programs are compiled once: for all values, and for the next process.


def compilations(code, cache):
    """How often JAX compiled something for the image while `code` ran in a new process."""
    counted = (
        "import json, logging, jax, raytrace\n"
        "from jax._src import monitoring\n"
        "events = []\n"
        "monitoring.register_event_duration_secs_listener(lambda name, seconds, **_: events.append(name))\n"
        "def compiled():\n"
        "    return sum(name.endswith('backend_compile_duration') for name in events)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", counted + code], check=True, capture_output=True, text=True,
        env=os.environ | {"RAYTRACE_CACHE": str(cache)},
    )  # fmt: skip
    return json.loads(ended.stdout)


@pytest.mark.parametrize("n", some([0, 300], 0))
def test_other_values_are_not_compiled_again(n):
    code = (
        f"n = {n}\n"
        "from dataclasses import replace\n"
        "def drawn(*changes, n=0):\n"
        "    scene = raytrace.load_scene('checkerboard', list(changes))\n"
        "    if n:\n"
        "        import numpy as np\n"
        "        random = np.random.default_rng(len(changes))\n"
        "        center, color = random.uniform(-3, 3, (n, 3)), random.uniform(0, 1, (n, 3))\n"
        "        spheres = raytrace.Spheres(center, random.uniform(.1, .2, n), color)\n"
        "        scene = replace(scene, spheres=spheres)\n"
        "    raytrace.render(scene, (40, 20)).block_until_ready()\n"
        "drawn(n=n); first = compiled()\n"
        "drawn('sun.direction=[0,1,0]', n=n); drawn('camera.position=[0,1,3]', 'sky.low=[0,0,0]', n=n)\n"
        "if not n: raytrace.render('checkerboard', (40, 20), skip=False).block_until_ready()\n"
        "print(json.dumps([first > 0, compiled() - first]))\n"
    )
    assert compilations(code, "off") == [True, 0]


def test_the_next_process_does_not_compile(tmp_path):
    code = "raytrace.render('skybox', (40, 20)).block_until_ready(); print(json.dumps(compiled()))"
    assert compilations(code, tmp_path) > 0
    assert len(list(tmp_path.glob("*.program"))) == 1
    assert compilations(code, tmp_path) == 0


def test_a_cache_that_cannot_be_written_is_no_error(tmp_path):
    (tmp_path / "file").write_text("")
    code = "raytrace.render('skybox', (40, 20)).block_until_ready(); print(json.dumps(compiled()))"
    assert compilations(code, tmp_path / "file") > 0


@pytest.mark.full
def test_memory_does_not_grow_with_the_height(tmp_path):
    """An image goes to its file as it is rendered: 24576 rows more, of 0.56 GiB, take much less memory than that."""
    render = ("-m", "raytrace", "render", "-o", str(tmp_path / "a.exr"), "--size")
    short, tall = (peak_memory(*render, f"2048x{rows}") for rows in (4096, 28672))
    assert tall - short < 0.2 * 2**30


@pytest.mark.full
def test_what_is_made_of_traced_images_does_not_wait_for_ever():
    """A mean and its derivative, many times in flight: with the image on several devices XLA's threads ran out."""
    code = (
        "import jax\n"
        "jax.config.update('jax_num_cpu_devices', 2)\n"
        "import jax.numpy as jnp, numpy as np, raytrace\n"
        "from dataclasses import replace\n"
        "scene = raytrace.load_scene('skybox')\n"
        "def loss(azimuth):\n"
        "    sun = replace(scene.sun, direction=raytrace.sun_direction(azimuth, 36.9))\n"
        "    return jnp.mean(raytrace.render(replace(scene, sun=sun), (192, 108)) ** 2)\n"
        "program = jax.jit(lambda azimuth: jax.jvp(loss, (azimuth,), (1.0,)))\n"
        "for _ in range(5): found = np.array([program(135.0 + k) for k in range(60)])\n"
        "assert len(jax.devices()) == 2\n"
        "assert np.isfinite(found).all()\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=100)
