"""Which numbers of a scene move edges."""

from raytrace.language.tree import tree_map
from raytrace.shader.uniforms import Program, Uniforms

__all__ = ["moving_edges"]


def moving_edges(uniforms: Uniforms, program: Program) -> Uniforms:
    """Return True in the place of each number that moves an edge in the picture, and False in that of the others.

    Places and sizes do, and the camera; colours do not, nor does the sun where nothing casts a shadow.
    """

    def all_of(structure, moves):
        return tree_map(lambda _: moves, structure)

    none, spheres, planes = all_of(uniforms, False), uniforms.spheres, uniforms.planes
    if spheres is not None:
        none = none._replace(
            spheres=none.spheres._replace(center=all_of(spheres.center, True), radius=all_of(spheres.radius, True))
        )
    if planes is not None:
        places = {name: all_of(getattr(planes, name), True) for name in ("point", "normal", "tile_size")}
        none = none._replace(planes=none.planes._replace(**places))
    casting = spheres is not None or uniforms.shadow_planes is not None
    shadows = program.lighting == "shadow" and casting
    return none._replace(
        camera=all_of(uniforms.camera, True),
        shadow_planes=all_of(uniforms.shadow_planes, True),
        sun=none.sun._replace(direction=all_of(uniforms.sun.direction, shadows)),
    )
