import json
import subprocess
import sys
import time
from math import inf

import numpy as np
import pytest

import raytrace
from raytrace.comparison import failures

RANDOM = np.random.default_rng(0)


def pair():
    a = RANDOM.uniform(0, 1, (20, 30, 3))
    b = a.copy()
    b[4, 7, 1] += 0.25
    return a, b


def strict(text):
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_what_is_told_of_one_wrong_pixel():
    found = raytrace.compare(*pair())
    assert (found.size, found.over, found.share) == ((30, 20), 1, 1 / 600)
    assert found.largest == (pytest.approx(0.25), 7, 4, "green")
    assert found.rmse == pytest.approx(0.25 / np.sqrt(1800))
    assert found.searched
    assert found.diagnosis is None
    assert found.regions == ()


def test_equal_images_and_strict_json():
    a, _ = pair()
    found = raytrace.compare(a, a)
    assert found.psnr == inf
    assert not found.searched
    report = strict(found.to_json())
    assert (report["psnr"], report["rmse"], report["diagnosis"]) == ("inf", 0, None)
    assert report["ssim"]["mean"] == pytest.approx(1)


def test_json_has_what_the_table_has():
    steps = raytrace.render("spheres", (48, 27), backend="numpy", output="steps")
    found = raytrace.compare(steps["display"], steps["display"][::-1], scene="spheres", names=("mine", "<theirs>"))
    report = strict(found.to_json())
    assert report["b"] == "<theirs>"
    assert report["diagnosis"]["mistake"] == "flipped top to bottom (y)"
    assert report["diagnosis"]["over"] == [found.over, 0]
    assert report["regions"][0] == {"name": "sky", "over": found.regions[0].over, "pixels": found.regions[0].pixels}
    printed = str(found)
    assert "<theirs> is flipped top to bottom (y): explains 100.0 % of the squared difference" in printed
    assert "67.02 pixels per degree" in printed
    for region in found.regions:
        assert f"{region.over} of {region.pixels:>7} pixels over 1/255" in printed
    html = found._repr_html_()
    assert html.count("<tr>") == len(printed.splitlines())
    assert "&lt;theirs&gt;" in html
    assert "<theirs>" not in html


def test_a_one_pixel_image():
    found = raytrace.compare(np.full((1, 1, 3), 0.25), np.full((1, 1, 3), 0.5))
    assert (found.ssim, found.rmse, found.over, found.diagnosis) == (None, 0.25, 1, None)
    assert "undefined: under 11x11" in str(found)
    assert strict(found.to_json())["ssim"] is None
    assert failures(found, {"min_ssim": -1}) == ["SSIM is undefined, must be at least -1"]


def test_constant_images():
    found = raytrace.compare(np.full((12, 12, 3), 0.5), np.full((12, 12, 3), 0.5))
    assert (found.psnr, found.over) == (inf, 0)
    assert failures(found, {"min_ssim": 1 - 1e-12, "min_psnr": 200, "max_flip": 0, "max_difference": 0}) == []


@pytest.mark.parametrize("dtype", ["float16", "float32", "longdouble"])
def test_any_floats_and_jax_arrays(dtype):
    a, b = (image.astype(dtype) for image in pair())
    assert raytrace.compare(a, b).over == 1
    image = raytrace.render("sphere", (16, 16))
    assert raytrace.compare(image, np.asarray(image)).largest.value == 0


def test_it_is_quick():
    """480x270, without mistakes to seek: about 0.4 s on this project's machines, with the libraries loaded."""
    a = RANDOM.uniform(0, 1, (270, 480, 3))
    b = np.clip(a + 1e-3, 0, 1)
    raytrace.compare(a[:16, :16], b[:16, :16])
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        raytrace.compare(a, b)
        seconds.append(time.perf_counter() - start)
    assert min(seconds) < 2


def test_importing_raytrace_is_light():
    heavy = "skimage colour flip_evaluator matplotlib OpenImageIO scipy jax"
    code = f"import sys, raytrace.comparison; print([x for x in '{heavy}'.split() if x in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.strip()
    assert loaded in ("[]", "['jax']")
