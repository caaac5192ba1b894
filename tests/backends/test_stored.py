"""Programs on disk and in memory: no more of either than is promised."""

import gc
from pathlib import Path

import pytest

import raytrace
from raytrace.backends.jax import Staged, renderer, stored
from raytrace.backends.job import Job
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame


def test_the_folder_keeps_what_was_used_last(tmp_path, monkeypatch):
    monkeypatch.setenv("RAYTRACE_CACHE", str(tmp_path))
    for width in (8, 9):
        raytrace.render("skybox", (width, 4))
    renderer._compiled.cache_clear()
    raytrace.render("skybox", (8, 4))  # which makes it the newest
    sizes = [path.stat().st_size for path in tmp_path.glob("*.program")]
    assert len(sizes) == 2
    monkeypatch.setattr(stored, "MOST", sum(sizes) - 1)
    stored._prune(tmp_path)
    assert len(list(tmp_path.glob("*.program"))) == 1
    renderer._compiled.cache_clear()
    monkeypatch.setattr(stored, "_prune", lambda place: pytest.fail("compiled again"))
    raytrace.render("skybox", (8, 4))


def mappings():
    return Path("/proc/self/maps").read_text().count("\n")


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="needs Linux's list of memory mappings")
def test_a_program_that_is_not_held_is_freed():
    """JAX's own caches do not hold it either. A program takes hundreds of the mappings that a process may have."""

    def draw(width):
        scene = raytrace.load_scene("skybox")
        job = Job(program_of(scene, "robust"), Frame(width, 4), ("display",), "float32", engine=Staged(block=64))
        renderer.Renderer(uniforms_of(scene, width / 4), job).draw(0, 4)

    draw(8)
    with_one = mappings()
    renderer._compiled.cache_clear()
    gc.collect()
    without = mappings()
    draw(9)
    renderer._compiled.cache_clear()
    gc.collect()
    assert without < with_one - 30
    assert mappings() < without + 30
