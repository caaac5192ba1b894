"""Settings of the whole suite. Annotations of the package are checked at run time: see pyproject.toml."""

import os

import pytest
from hypothesis import HealthCheck, settings

from raytrace.backends.gpu.process import engine_process
from raytrace.errors import InputError

settings.register_profile(
    "raytrace", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow], print_blob=False
)
settings.load_profile("raytrace")


@pytest.fixture(autouse=True)
def in_empty_folder(tmp_path, monkeypatch):
    """Every test runs in a folder of its own, so that what it writes by default goes there."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(params=["opengl", "webgl"])
def engine(request):
    """The name of a graphics engine. Where it is missing the test is skipped, unless all are required."""
    try:
        engine_process(request.param).about()
    except InputError as missing:
        if os.environ.get("RAYTRACE_TEST_EVERYTHING"):
            raise
        pytest.skip(str(missing))
    return request.param
