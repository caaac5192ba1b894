"""Settings of the whole suite.

By default one example of each kind is run. `--full` runs all of them: every built-in scene, every choice, full-size
images, many random examples.
"""

import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from raytrace.backends.gpu.drawing import Unavailable
from raytrace.backends.gpu.webgl import chromium
from tests.engines import need, skip_unless_required

for profile, examples in (("default", 25), ("full", 100)):
    settings.register_profile(
        profile,
        max_examples=examples,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow],
        print_blob=False,
        database=None,
    )

#: The files that take longest, which begin first, so that the workers end together.
LONGEST = (
    "test_antialias.py",
    "test_gradients.py",
    "test_skipping.py",
    "test_jax.py",
    "test_bounds.py",
    "test_devices.py",
    "test_fit.py",
    "test_cli.py",
)

#: How many tests were left out.
LEFT_OUT = pytest.StashKey[int]()


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="run the full set: every scene, every choice, many examples")


def pytest_configure(config):
    config.stash[LEFT_OUT] = 0
    if getattr(config.option, "dist", "no") == "load":
        # A file's tests share compiled programs: one worker runs them all, in the order of `LONGEST`.
        config.option.dist, config.option.loadscopereorder = "loadfile", False
    # Before the tests are imported, which ask for it.
    settings.load_profile("full" if config.option.full else "default")


def pytest_collection_modifyitems(config, items):
    ranks = {name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path.name, len(ranks)))
    # What is asked for by its name is run.
    if config.option.full or any("::" in argument for argument in config.args):
        return
    left_out = [item for item in items if item.get_closest_marker("full")]
    items[:] = [item for item in items if not item.get_closest_marker("full")]
    config.hook.pytest_deselected(items=left_out)
    config.stash[LEFT_OUT] = len(left_out)


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["left_out"] = session.config.stash[LEFT_OUT]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    # Every worker has collected, and left out, the same tests.
    node.config.stash[LEFT_OUT] = getattr(node, "workeroutput", {}).get("left_out", 0)


def pytest_terminal_summary(terminalreporter, config):
    if config.stash[LEFT_OUT]:
        terminalreporter.write_line(
            f"Left out: {config.stash[LEFT_OUT]} tests of the full set (every scene and choice, full-size images), and "
            "most random examples.\nTo run them too: pytest -n 2 --full"
        )


@pytest.fixture(scope="session", autouse=True)
def programs(tmp_path_factory):
    """Compiled programs are kept for the run, in a folder that all workers and their children share."""
    folder = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAYTRACE_CACHE", str(folder / "programs"))
        yield


@pytest.fixture(autouse=True)
def in_empty_folder(tmp_path, monkeypatch):
    """Every test runs in a folder of its own, so that what it writes by default goes there."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(autouse=True, scope="module")
def not_too_many_programs():
    """JAX keeps what tests compile, each with hundreds of memory mappings, of which Linux lets a process have 65530."""
    yield
    maps = Path("/proc/self/maps")
    if "jax" in sys.modules and maps.exists() and maps.read_text().count("\n") > 30_000:
        sys.modules["jax"].clear_caches()
        gc.collect()


@pytest.fixture(params=["opengl", "webgl"])
def engine(request):
    """The name of a graphics engine. Where it is missing the test is skipped, unless all are required."""
    need(request.param)
    return request.param


@pytest.fixture(scope="session")
def browser():
    """Chromium. Where it is missing the test is skipped, unless all are required."""
    try:
        try:
            from playwright.sync_api import sync_playwright
        except ImportError:
            raise Unavailable("needs Playwright: pip install playwright") from None
        with sync_playwright() as playwright:
            started = chromium(playwright)
            yield started
            started.close()
    except Unavailable as missing:
        skip_unless_required(missing)
