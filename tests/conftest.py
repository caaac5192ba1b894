"""Settings of the whole suite. Annotations of the package are checked at run time: see pyproject.toml."""

import gc
import sys
from pathlib import Path

import jaxtyping
import pytest
from hypothesis import HealthCheck, settings

from raytrace.backends.gpu.drawing import Unavailable
from raytrace.backends.gpu.webgl import chromium
from tests.engines import need, skip_unless_required

settings.register_profile(
    "raytrace", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow], print_blob=False
)
settings.load_profile("raytrace")


@pytest.fixture(autouse=True)
def in_empty_folder(tmp_path, monkeypatch):
    """Every test runs in a folder of its own, so that what it writes by default goes there."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(autouse=True)
def not_too_many_programs():
    """JAX keeps every program, each with hundreds of memory mappings, of which Linux lets a process have 65530."""
    yield
    maps = Path("/proc/self/maps")
    if "jax" in sys.modules and maps.exists() and maps.read_text().count("\n") > 30_000:
        sys.modules["jax"].clear_caches()
        gc.collect()


@pytest.fixture(autouse=True)
def types_are_checked(request):
    """In all but slow tests, and those that are marked so: the checks take several times as long as what they check."""
    unchecked = any(map(request.node.get_closest_marker, ("slow", "unchecked")))
    jaxtyping.config.update("jaxtyping_disable", unchecked)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


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
