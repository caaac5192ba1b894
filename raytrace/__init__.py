"""raytrace: the vectorized reference implementation of a real-time graphics course's ray tracer.

The public names are in `__init__.pyi`, with the modules that they come from. A module is imported when one of its names
is used first.
"""

import lazy_loader as _lazy_loader

from raytrace.showing import PNG as _PNG

__getattr__, __dir__, __all__ = _lazy_loader.attach_stub(__name__, __file__)


def _scene_as_png(scene):
    from raytrace.notebook.pictures import scene_as_png

    return scene_as_png(scene)


_PNG["scene"] = _scene_as_png
