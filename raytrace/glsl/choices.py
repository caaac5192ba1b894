"""What shapes the text of the GLSL: the choices of a scene, and of whoever asks for it."""

from dataclasses import dataclass

import numpy as np

from raytrace.errors import InputError
from raytrace.language.control import count
from raytrace.language.glsl import Vec3
from raytrace.language.tree import tree_leaves
from raytrace.scene.data import Checkerboard
from raytrace.shader.uniforms import Plane, Program, Uniforms

__all__ = ["Choices", "choices_of"]

#: Vectors of four that GLSL ES 3.00 promises a fragment shader for its uniforms, less what camera, sun, sky and film
#: take; a sphere takes three of them, a plane six.
UNIFORM_VECTORS = 224 - 24
#: Constants that compilers take without complaint.
CONSTANT_VECTORS = 6144


@dataclass(frozen=True)
class Choices:
    """Everything that the text depends on but the scene's numbers; hashable.

    data: "constants", but for the camera, or "uniforms".
    output: what the shader gives: "display", "linear", or "steps", one of them by the uniform ``shownStep``.
    samples: n for n x n samples a pixel of an image of the size `size`.
    printed_checkerboard: the colours are the assignment's own, which stand in its function.
    spheres_in_texture: there are more than uniforms (or constants) can hold.
    """

    spheres: int
    planes: int
    shadow_planes: int
    lighting: str
    intersection: str
    orthographic: bool
    patterned: bool
    printed_checkerboard: bool
    tone_mapper: str
    transfer: str
    exposure: bool
    white_balance: bool
    data: str = "constants"
    output: str = "display"
    samples: int = 1
    size: tuple[int, int] = (1, 1)

    @property
    def spheres_in_texture(self) -> bool:
        most = CONSTANT_VECTORS if self.data == "constants" else UNIFORM_VECTORS
        return 3 * self.spheres + 6 * (self.planes + self.shadow_planes) > most

    @property
    def all_planes_cast(self) -> bool:
        return self.planes == self.shadow_planes


def choices_of(
    uniforms: Uniforms,
    program: Program,
    *,
    data: str = "constants",
    output: str = "display",
    samples: int = 1,
    size: tuple[int, int] = (1, 1),
) -> Choices:
    """The choices for a scene's uniforms and program.

    Raises:
        InputError: the tone mapper is a Python function, or there are more planes than uniforms can hold, or
            shadow rays do not start where the assignment's do.
    """
    planes, shadow_planes = count(uniforms.planes), count(uniforms.shadow_planes)
    if 6 * (planes + shadow_planes) > UNIFORM_VECTORS:
        raise InputError(
            f"planes: a GLSL shader holds {UNIFORM_VECTORS // 6}, those that cast shadows counted twice, "
            f"found {planes + shadow_planes}"
        )
    if program.shadow_start != "offset":
        raise InputError(
            f"shadow_start: only 'offset', the assignment's, is written in GLSL, found {program.shadow_start!r}"
        )
    if not isinstance(program.tone_mapper, str) or not isinstance(program.transfer, str):
        raise InputError("film.tone_mapper: a Python function cannot be written in GLSL")
    return Choices(
        spheres=count(uniforms.spheres),
        planes=planes,
        shadow_planes=shadow_planes,
        lighting=program.lighting,
        intersection=program.intersection,
        orthographic=program.orthographic,
        patterned=program.patterned,
        printed_checkerboard=data == "constants"
        and program.patterned
        and uniforms.planes is not None
        and _printed(uniforms.planes),
        tone_mapper=program.tone_mapper,
        transfer=program.transfer,
        exposure=uniforms.film.exposure is not None,
        white_balance=uniforms.film.white_balance is not None,
        data=data,
        output=output,
        samples=samples,
        size=size if samples > 1 else (1, 1),
    )


def _printed(planes: Plane | None) -> bool:
    """Whether every plane has the colours of the assignment's checkerboard."""
    printed = Checkerboard()
    return planes is not None and all(
        np.array_equal(np.float32(leaf), np.full(count(planes), np.float32(value)))
        for colors, values in (
            (planes.even, printed.even),
            (planes.odd, printed.odd),
            (planes.line, printed.line),
        )
        for leaf, value in zip(tree_leaves(Vec3(*colors)), values, strict=True)
    )
