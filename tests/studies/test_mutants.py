"""The mutation study: each mistake can be made, and bounds tell it from what correct engines print."""

import pytest

import raytrace
from raytrace.export.shaders import glsl
from raytrace.mistakes import MUTATIONS
from raytrace.studies.mutants import DETECTORS, SCENES, study
from tests.engines import need


def test_every_mistake_can_be_made_and_changes_the_text():
    texts = [glsl(raytrace.load_scene(name), (96, 54), data="uniforms") for name in SCENES]
    for mutation in MUTATIONS:
        changed = [mutation.applied(text) for text in texts]
        assert any(changed), mutation.name
        assert all(new not in texts for new in changed), mutation.name
    assert len({mutation.name for mutation in MUTATIONS}) == len(MUTATIONS) >= 30


@pytest.mark.full
def test_bounds_find_mistakes_and_no_correct_engine():
    need("opengl")
    names = ("sky gradient 0.26", "y flipped")
    chosen = tuple(mutation for mutation in MUTATIONS if mutation.name in names)
    result = study((96, 54), ("checkerboard",), chosen)
    assert result.false_alarms == ()
    assert result.tried == dict.fromkeys(names, 1)
    assert result.found["y flipped"] == dict.fromkeys(DETECTORS, 1)
    assert result.found["sky gradient 0.26"]["bounds"] == 1
    assert result.caught("bounds") == 1
