"""The program of a picture with edges and its slopes, kept for the next process."""

import os
import subprocess
import sys

import numpy as np
import pytest

pytestmark = pytest.mark.full


def test_the_next_process_has_the_program_whatever_its_devices(tmp_path):
    """The program is kept; it runs on one device where there are several, and the slopes are the same."""
    code = (
        "import sys, jax\n"
        "jax.config.update('jax_num_cpu_devices', int(sys.argv[1]))\n"
        "import numpy as np, raytrace\n"
        "from raytrace.inverse.slopes import sun_slopes\n"
        "np.save(sys.argv[2], sun_slopes(raytrace.load_scene('sphere'), (16, 16), np.eye(3)[:2])[1])\n"
    )
    env = os.environ | {"RAYTRACE_CACHE": str(tmp_path / "kept")}
    found = []
    for devices in ("2", "1", "2"):
        path = str(tmp_path / "slopes.npy")
        subprocess.run([sys.executable, "-c", code, devices, path], check=True, env=env, timeout=200)
        found.append(np.load(path))
    assert len(list((tmp_path / "kept").glob("*.program"))) == 1
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
