"""GLSL's scalar types, as annotations: an array of any library, one number a pixel or one for all (shape ()).

The tests check them at run time (jaxtyping and beartype).
"""

import re
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from jaxtyping import AbstractDtype
from jaxtyping import Bool as BoolDtype
from jaxtyping import Int as IntDtype

__all__ = ["Array", "Bool", "Float", "Int"]

#: An array of any conforming library: NumPy, JAX (concrete or traced), or a type of one's own.
Array: TypeAlias = Any


class Real(AbstractDtype):
    """Floating point of any width, and number types of one's own whose names have "float" in them."""

    dtypes: ClassVar = [re.compile(".*float.*|longdouble")]


if TYPE_CHECKING:
    Float: TypeAlias = Any
    Bool: TypeAlias = Any
    Int: TypeAlias = Any
else:
    Float = Real[Any, "*#pixels"]
    Bool = BoolDtype[Any, "*#pixels"]
    Int = IntDtype[Any, "*#pixels"]
