"""An extension of the assignment: pixels as means over their squares, `antialias="edges"`.

Numbers are jets there (`raytrace.language.jet`): planes that know how they change from one pixel to the next. So it is
known where an edge runs in a pixel; the pixel has the share of either side; and the image's derivatives see edges move.
"""

from raytrace.edges.pixel import pixels

__all__ = ["pixels"]
