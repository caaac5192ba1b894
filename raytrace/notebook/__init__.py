"""For Jupyter: a scene to look around in, pictures side by side, and exercises that are checked."""

from pathlib import Path
from typing import TYPE_CHECKING

from raytrace.errors import InputError
from raytrace.notebook.exercise import Answer, check
from raytrace.notebook.pictures import Pictures, pictures, png
from raytrace.rendering import check_size
from raytrace.scene import Scene
from raytrace.scene.toml import as_scene

if TYPE_CHECKING:
    from raytrace.notebook.widget import View

__all__ = ["Answer", "Pictures", "check", "pictures", "png", "view"]

SAMPLES = (1, 2, 4, 8)


def view(scene: Scene | str | Path = "checkerboard", size: tuple[int, int] = (640, 360), samples: int = 4) -> "View":
    """The scene in Jupyter: drag to go around it, turn the wheel to go nearer; sliders for the sun and the film.

    While something changes the picture has a sample a pixel; at rest it has samples x samples. The `scene` of what this
    gives is the scene as it is now seen.

    size: (width, height) in pixels. samples: 1, 2, 4 or 8.

    Raises:
        InputError: the scene, the size or the samples are not such; the extra `notebooks` is not installed.
    """
    check_size(size)
    if samples not in SAMPLES:
        raise InputError(f"samples: must be 1, 2, 4 or 8, found {samples!r}")
    scene = as_scene(scene)
    try:
        from raytrace.notebook.widget import View
    except ModuleNotFoundError as error:
        raise InputError(f"view: needs {error.name}, which the extra has: pip install 'raytrace[notebooks]'") from None
    width, height = size
    return View(scene, (width, height), samples)
