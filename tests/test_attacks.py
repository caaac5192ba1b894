"""Sixty of the attacks; ``python -m tests.attacks`` runs as many as it is asked for."""

import pytest

from tests.attacks import GROUPS, attacks, run
from tests.engines import need

FEW = len(GROUPS)


@pytest.mark.parametrize(
    "attack",
    [pytest.param(attack, marks=() if i < FEW else pytest.mark.full) for i, attack in enumerate(attacks(60))],
    ids=lambda attack: attack.name,
)
def test_it_holds(attack):
    if attack.group == "shaders":
        need("opengl")
    assert run(attack).wrong == ""
