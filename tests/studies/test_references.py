"""The benchmark's files."""

import numpy as np
import pytest

from raytrace.errors import InputError
from raytrace.studies.differences import block_sums
from raytrace.studies.references import STORED, read_benchmark, read_theirs, referenced, write_benchmark
from raytrace.studies.worlds import PARAMETERS, worlds
from tests.scenes import some

WORLDS = {world.name: world for world in worlds()}
HELD = {each.world.name: each for each in read_benchmark()}


def test_every_world_is_stored_as_its_recipe_makes_it():
    assert HELD.keys() == WORLDS.keys()
    for name, held in HELD.items():
        # Equal by value, bit for bit.
        assert held.world == WORLDS[name]


def test_the_files_are_small():
    assert sum(file.stat().st_size for file in STORED.iterdir()) < 1_000_000


@pytest.mark.parametrize("name", some(["small-lit", "small-red-0.13", "inside-a-sphere-0"], "small-red-0.13"))
def test_a_stored_reference_is_what_its_recipe_makes(name):
    made = referenced(HELD[name].world)
    for parameter, (blocks, error) in HELD[name].references.items():
        again = made.references[parameter][0]
        np.testing.assert_allclose(again, blocks, rtol=0, atol=np.abs(error).max() + 1e-3 * np.abs(blocks).max())


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_references_are_mostly_three_times_as_exact_as_the_limits(parameter):
    every = [held.references[parameter] for held in HELD.values() if parameter in held.references]
    own = [np.abs(error).sum() / np.abs(blocks).sum() for blocks, error in every if blocks.any()]
    assert np.median(own) < PARAMETERS[parameter].limits[1] / 3


def test_what_is_written_is_read_and_other_worlds_are_kept(tmp_path):
    one, other = WORLDS["small-red-0.48"], WORLDS["small-lit"]
    counted = []
    write_benchmark(tmp_path, [one], counted.append)
    (first,) = read_benchmark(tmp_path)
    assert first.world == one
    assert counted == [len(one.parameters)]
    write_benchmark(tmp_path, [other])
    found = {each.world.name: each for each in read_benchmark(tmp_path)}
    assert found.keys() == {one.name, other.name}
    for parameter, arrays in first.references.items():
        np.testing.assert_array_equal(found[one.name].references[parameter], arrays)


def saved(path, **arrays):
    np.savez(path, **arrays)
    return path


def test_theirs_may_be_pictures_or_sums(tmp_path):
    image = np.random.default_rng(0).normal(size=(18, 32, 3))
    key = ("small-lit", "sun azimuth")
    sums = block_sums(image)
    for array in (image, image.mean(-1), sums):
        found = read_theirs(saved(tmp_path / "a.npz", **{"/".join(key): array}), HELD.values())
        np.testing.assert_allclose(found[key], sums, rtol=1e-12)
        assert found.keys() == {key}


@pytest.mark.parametrize(
    ("arrays", "told"),
    [
        ({"moon/sun azimuth": np.zeros((1, 2))}, "key: unknown 'moon/sun azimuth'"),
        ({"small-lit/sun azimuth": np.zeros((2, 2))}, "must have shape (1, 2), (18, 32) or (18, 32, 3), found (2, 2)"),
        ({"small-lit/sun azimuth": np.full((1, 2), np.nan)}, "must be finite"),
        ({"small-lit/sun azimuth": np.array([["a", "b"]])}, "must be real numbers"),
        ({"small-lit/sun azimuth": np.array([[None, None]])}, "not an .npz of numbers"),
        ({}, "holds no derivative"),
    ],
)
def test_theirs_that_are_wrong(tmp_path, arrays, told):
    with pytest.raises(InputError) as error:
        read_theirs(saved(tmp_path / "a.npz", **arrays), HELD.values())
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_are_none(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_theirs(tmp_path / "nowhere.npz", HELD.values())
    with pytest.raises(InputError, match="is not a regular file"):
        read_theirs(tmp_path, HELD.values())
    (tmp_path / "a.npz").write_text("text")
    with pytest.raises(InputError, match=r"not an \.npz"):
        read_theirs(tmp_path / "a.npz", HELD.values())
    np.save(tmp_path / "b.npy", np.zeros(3))
    with pytest.raises(InputError, match=r"not an \.npz"):
        read_theirs(tmp_path / "b.npy", HELD.values())


def test_a_folder_that_is_wrong(tmp_path):
    with pytest.raises(InputError, match=r"worlds\.toml: no such file"):
        read_benchmark(tmp_path)
    listed = tmp_path / "worlds.toml"
    for text, told in (("block = 5", "block: must be 12"), ("block = 12", "must have worlds"), ("=", "not TOML")):
        listed.write_text(text)
        with pytest.raises(InputError, match=told):
            read_benchmark(tmp_path)
    listed.write_text("block = 12\n[worlds.small]\nsize = 3")
    np.savez(tmp_path / "references.npz")
    with pytest.raises(InputError, match=r"worlds\.small: must have size"):
        read_benchmark(tmp_path)
