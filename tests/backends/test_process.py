"""The engines' processes: what they may take, and when they end."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest

import raytrace
from raytrace.backends.gpu.drawing import ShaderProgram
from raytrace.backends.gpu.process import TIME_LIMIT, EngineProcess
from raytrace.backends.gpu.webgl import chromium
from raytrace.glsl import vertex_shader
from tests.engines import need
from tests.scenes import some

#: By default the engine that starts sooner: what is tested is how any of them is run.
BY_DEFAULT = pytest.mark.parametrize("engine", some(["opengl", "webgl"], "opengl"))

#: Under `nohup` a child would ignore SIGHUP as the suite does.
ASKER = """
import signal
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from raytrace.backends.gpu.process import engine_process
process = engine_process({engine!r})
process.about()
print(process._process.pid, flush=True)
{then}
"""


def bomb(levels):
    """A text that is 10**levels times as long for a compiler."""
    powers = "".join(f"#define A{i} {' '.join([f'A{i - 1}'] * 10)}\n" for i in range(1, levels + 1))
    head = "#version 300 es\nprecision highp float; out vec4 color;\n#define A0 x += sin(x);\n"
    return ShaderProgram(
        vertex_shader(), f"{head}{powers}void main(){{ float x = 0.;\nA{levels}\ncolor = vec4(x); }}\n"
    )


@BY_DEFAULT
def test_memory_has_a_limit(engine):
    need(engine)
    process = EngineProcess(engine, memory=600 << 20)
    process.about()
    with pytest.raises(
        raytrace.EngineFailure, match=rf"^backend {engine}: (took more than 0\.6 GiB|the engine crashed)"
    ):
        process.active_uniforms(bomb(8), limit=100.0)
    assert process.about()  # the next one starts anew
    process.stop()


def family(pid):
    process = psutil.Process(pid)
    return [process, *process.children(recursive=True)]


@BY_DEFAULT
@pytest.mark.parametrize("end", some([signal.SIGKILL, signal.SIGHUP], signal.SIGKILL))
def test_the_engine_ends_with_who_asked(engine, end):
    need(engine)
    code = ASKER.format(engine=engine, then="import time; time.sleep(100)")
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as asker:
        processes = family(int(asker.stdout.readline()))
        assert len(processes) > 1  # its guard, at least
        os.kill(asker.pid, end)
        asker.wait()
    _, alive = psutil.wait_procs(processes, timeout=10)
    assert alive == []


@BY_DEFAULT
def test_a_thread_that_asked_may_end(engine):
    """Linux would end a child with the thread that started it, were that asked for."""
    need(engine)
    process = EngineProcess(engine)
    thread = threading.Thread(target=process.about)
    thread.start()
    thread.join()
    time.sleep(0.3)
    assert process._process.poll() is None
    process.stop()


def test_the_start_takes_none_of_the_shaders_time(engine, monkeypatch):
    """Chromium needs a second or more."""
    need(engine)
    asked, ask = [], EngineProcess._ask

    def recorded(self, method, arguments, limit, images=0):
        asked.append((method, limit))
        return ask(self, method, arguments, limit, images)

    monkeypatch.setattr(EngineProcess, "_ask", recorded)
    Path("a.frag").write_text("#version 300 es\nprecision highp float; out vec4 c; void main(){ c = vec4(1.); }")
    raytrace.render("sphere", (4, 4), backend=engine, shader="a.frag", time_limit=50.0)
    assert asked[0] == ("about", TIME_LIMIT)
    assert {limit for method, limit in asked if method != "about"} == {50.0}


@pytest.mark.parametrize(("user", "sandbox"), [(0, False), (1000, True)])
def test_chromium_keeps_its_sandbox_unless_root(user, sandbox, monkeypatch):
    asked = {}

    class Playwright:
        class chromium:
            @staticmethod
            def launch(**options):
                asked.update(options)

    monkeypatch.setattr("raytrace.backends.gpu.webgl.shutil.which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(os, "geteuid", lambda: user, raising=False)
    chromium(Playwright)
    assert asked["chromium_sandbox"] is sandbox
    assert "--no-sandbox" not in asked["args"]
