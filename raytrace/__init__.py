"""raytrace: the vectorized reference implementation of a real-time graphics course's ray tracer.

The public names are in `__init__.pyi`, with the modules that they come from. A module is imported when one of its names
is used first.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
