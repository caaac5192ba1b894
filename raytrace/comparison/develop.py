"""The scene's film, over arrays: from linear light to display values, and back where that is one number."""

import numpy as np

from raytrace.language.glsl import Vec3
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import program_of, rounded, uniforms_of
from raytrace.shader.film import develop
from raytrace.shader.uniforms import FilmUniforms, Program

__all__ = ["NEUTRAL", "developed", "film_of", "undeveloped"]

#: No exposure and no white balance.
NEUTRAL = FilmUniforms(exposure=None, white_balance=None)

#: Grey light that a film is tried with: black, and from 1e-7 to 1e5.
_GREYS = np.concatenate([[0.0], np.geomspace(1e-7, 1e5, 1 << 14)])


def film_of(scene: Scene) -> tuple[FilmUniforms, Program]:
    """The film's numbers, rounded to float32 as every renderer is given them, and its program."""
    return rounded(uniforms_of(scene, 1.0).film), program_of(scene, "textbook")


def developed(linear: np.ndarray, film: FilmUniforms, program: Program) -> np.ndarray:
    """Display values of linear light, both (height, width, 3), in float64."""
    with np.errstate(all="ignore"):  # as the renderer does: what the shader then selects is finite
        return np.stack(develop(Vec3(*np.moveaxis(linear, -1, 0)), film, program), axis=-1)


def undeveloped(display: np.ndarray, program: Program) -> np.ndarray | None:
    """The least light, after exposure and white balance, that `program` makes these display values of.

    ``None`` where brighter light can be darker on display, with a tone mapper of one's own.
    """
    shown = developed(np.repeat(_GREYS[None, :, None], 3, axis=-1), NEUTRAL, program)[0, :, 0]
    if not (np.diff(shown) >= 0).all():
        return None
    shown, first = np.unique(shown, return_index=True)
    return np.interp(display, shown, _GREYS[first])
