"""For the tests of another project's renderer: golden images, made on the spot or read from a folder.

import pytest
from raytrace.testing import goldens

@pytest.mark.parametrize("golden", goldens(), ids=str)
def test_my_renderer(golden):
    golden.check(my_renderer(golden.scene, golden.size))
"""

from collections.abc import Iterable
from pathlib import Path

from raytrace.errors import InputError
from raytrace.golden import SIZE, Golden, golden_folder, golden_scenes

__all__ = ["Golden", "goldens"]


def goldens(
    folder: str | Path | None = None, scenes: Iterable[str] | None = None, size: tuple[int, int] = SIZE
) -> list[Golden]:
    """Golden images, each with its `scene`, its `size` and the method `check`.

    folder: one that `raytrace golden` has made. Without it the image of each is rendered when it is first needed, by
        NumPy in float64.
    scenes: names of built-in scenes, or scene files; by default all built-in scenes, or all of the folder.
    size: (width, height), where there is no folder.

    Raises:
        InputError: there is no such folder or scene, or a file of the folder is broken.
    """
    if folder is None:
        return [Golden(name, scene, size) for name, scene in golden_scenes(scenes).items()]
    held = golden_folder(folder)
    wanted = {golden.name for golden in held.goldens} if scenes is None else set(scenes)
    missing = wanted - {golden.name for golden in held.goldens}
    if missing:
        raise InputError(f"{folder}: holds no golden image {min(missing)!r}")
    broken = [problem for name in sorted(wanted) for problem in held.broken.get(name, ())]
    if broken:
        raise InputError(broken[0])
    return [golden for golden in held.goldens if golden.name in wanted]
