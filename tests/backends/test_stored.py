"""Programs on disk and in memory: no more of either than is promised."""

import gc
import logging
import os
from pathlib import Path

import pytest

import raytrace
from raytrace.backends.jax import Staged, renderer, stored
from raytrace.backends.job import Job
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame
from tests.scenes import some


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


def test_a_program_that_is_not_whole_is_removed_and_made_anew(tmp_path, monkeypatch):
    """Such a program could crash the process at every later run."""
    monkeypatch.setenv("RAYTRACE_CACHE", str(tmp_path))
    tmp_path.chmod(0o700)
    expected = raytrace.render("skybox", (10, 4))
    (path,) = tmp_path.glob("*.program")
    whole = path.read_bytes()
    flipped = [whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :] for at in (0, len(whole) // 2, len(whole) - 1)]
    for content in (*flipped, whole[:1000]):
        path.write_bytes(content)
        with pytest.raises(ValueError, match="program"):
            stored._whole(path)
        assert not path.exists()
    path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    renderer._compiled.cache_clear()
    assert (raytrace.render("skybox", (10, 4)) == expected).all()
    assert stored._whole(path)  # a whole one took its place


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="needs POSIX's owners and modes")
@pytest.mark.parametrize("mode", some([0o777, 0o770, 0o702], 0o770))
def test_a_folder_that_others_may_write_to_is_not_used(tmp_path, monkeypatch, mode):
    """A program is code, and loading it unpickles."""
    folder = tmp_path / "programs"
    folder.mkdir()
    folder.chmod(mode)
    monkeypatch.setenv("RAYTRACE_CACHE", str(folder))
    raytrace.render("skybox", (11, 4))
    renderer._compiled.cache_clear()
    assert list(folder.iterdir()) == []


def test_a_wait_is_logged_with_its_end(caplog, monkeypatch):
    monkeypatch.setenv("RAYTRACE_CACHE", "off")
    with caplog.at_level(logging.INFO, "raytrace"):
        assert stored.stored("a program", [], lambda: 1) == 1
        with pytest.raises(ZeroDivisionError):
            stored.stored("another", [], lambda: 1 / 0)
    assert [(record.levelname, record.waits) for record in caplog.records] == [("INFO", True), ("INFO", False)] * 2
