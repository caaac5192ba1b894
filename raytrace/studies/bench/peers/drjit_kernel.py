"""Dr.Jit on LLVM: the whole picture as one kernel over all pixels, which Dr.Jit traces from the shader's own text.

Its users would write the same formulas with its arrays. So here those arrays are the shader's arithmetic: both sides of
every branch are computed and selected from, loops are written out, and the scene's numbers are constants, as suits one
kernel. It needs LLVM's library (Debian: libllvm15 or newer) beside the package.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from raytrace.edges import pixels
from raytrace.errors import InputError
from raytrace.language.control import Engine, running
from raytrace.language.namespace import Unlimited
from raytrace.language.tree import count, tree_map
from raytrace.scene.data import Scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame
from raytrace.studies.bench.peers.llvm import llvm

__all__ = ["MOST", "frame"]

#: With more spheres than this the kernel, in which each is written out twice, takes long to compile.
MOST = 32


def frame(scene: Scene, size: tuple[int, int]) -> Callable[[], tuple]:
    """Return a function that draws the image: a plane for each of red, green and blue.

    Raises:
        InputError: LLVM's library is not installed, or there are more than `MOST` spheres.
    """
    if len(scene.spheres.radius) > MOST:
        raise InputError(f"one kernel holds at most {MOST} spheres, found {len(scene.spheres.radius)}")
    llvm()
    import drjit
    from drjit.llvm import Float, UInt32

    width, height = size
    numbers = tree_map(lambda leaf: np.asarray(leaf, np.float32), uniforms_of(scene, width / height))
    uniforms, program = tree_map(_constant, numbers), program_of(scene, "textbook")

    # Its text is traced once, and not for each frame.
    @drjit.freeze
    def drawn(pixel: Any) -> tuple:
        column, row = Numbers(Float(pixel % width)), Numbers(Float(pixel // width))
        with running(_Kernel()):
            color = pixels(uniforms, program, column, row, Frame(width, height), ("display",)).display
        return tuple(component.value for component in color)

    every = drjit.arange(UInt32, width * height)
    drjit.eval(every)

    def draw() -> tuple:
        planes = drawn(every)
        drjit.eval(*planes)
        drjit.sync_thread()
        return planes

    return draw


def _constant(leaf: np.ndarray) -> Any:
    from drjit.llvm import Float

    return _Items(leaf) if leaf.ndim else Numbers(Float(float(leaf)))


class _Items:
    """Some constants, of which the text takes single ones."""

    def __init__(self, values: np.ndarray):
        self.values, self.shape = values, values.shape

    def __getitem__(self, i: int) -> "Numbers":
        return _constant(self.values[i])


class _Kernel(Engine):
    """Everything is computed for every pixel."""

    def at(self, items: Any, index: "Numbers") -> Any:
        def chosen(leaf: _Items) -> Numbers:
            value = leaf[0]
            for i in range(1, count(items)):
                here: Any = index == i
                value = Namespace.where(here, leaf[i], value)
            return value

        return tree_map(chosen, items)


class Namespace:
    """What the shader asks of its arithmetic."""

    float32, int32, bool = "float32", "int32", "bool"

    @staticmethod
    def finfo(dtype: str) -> type[Unlimited]:
        """Return no limits: none of the guards of extreme numbers, which nobody would write here."""
        return Unlimited

    @staticmethod
    def asarray(value: Any, dtype: str = "float32") -> "Numbers":
        from drjit.llvm import Bool, Float, Int

        return Numbers({"float32": Float, "int32": Int, "bool": Bool}[dtype](value))

    @staticmethod
    def where(condition: "Numbers", a: "Numbers", b: "Numbers") -> "Numbers":
        import drjit

        return Numbers(drjit.select(condition.value, a.value, b.value))

    @staticmethod
    def minimum(a: "Numbers", b: "Numbers") -> "Numbers":
        # With LLVM 15 a kernel with Dr.Jit's own minimum does not compile.
        return Namespace.where(a < b, a, b)

    @staticmethod
    def maximum(a: "Numbers", b: "Numbers") -> "Numbers":
        return Namespace.where(a > b, a, b)

    @staticmethod
    def full_like(like: "Numbers", value: Any) -> "Numbers":
        return Namespace.asarray(value, like.dtype)


def _function(name: str) -> Callable:
    def function(x: "Numbers") -> "Numbers":
        import drjit

        return Numbers(getattr(drjit, name)(x.value))

    return staticmethod(function)


for _name in ("sqrt", "exp2", "log2", "floor", "isfinite"):
    setattr(Namespace, _name, _function(_name))


def _operator(operation: Callable) -> Any:
    def method(self: "Numbers", other: Any) -> Any:
        if isinstance(other, tuple) or hasattr(other, "like"):
            return NotImplemented  # a vector or a literal, which does it itself
        return Numbers(operation(self.value, other.value if isinstance(other, Numbers) else other))

    return method


def _reflected(operation: Callable) -> Any:
    return lambda self, other: Numbers(operation(other, self.value))


def _unary(operation: Callable) -> Any:
    return lambda self: Numbers(operation(self.value))


class Numbers:
    """A number for each pixel, or one for all: an array of Dr.Jit's."""

    # NumPy's operators then leave the operation to this class.
    __array_ufunc__ = None
    __slots__ = ("value",)
    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def __init__(self, value: Any):
        self.value = value

    def __array_namespace__(self) -> type[Namespace]:
        return Namespace

    @property
    def dtype(self) -> str:
        return {"Float": "float32", "Int": "int32", "Bool": "bool"}[type(self.value).__name__]

    @property
    def shape(self) -> tuple[int, ...]:
        return () if len(self.value) == 1 else (len(self.value),)

    __add__, __radd__ = _operator(operator.add), _reflected(operator.add)
    __sub__, __rsub__ = _operator(operator.sub), _reflected(operator.sub)
    __mul__, __rmul__ = _operator(operator.mul), _reflected(operator.mul)
    __truediv__, __rtruediv__ = _operator(operator.truediv), _reflected(operator.truediv)
    __and__, __or__, __invert__ = _operator(operator.and_), _operator(operator.or_), _unary(operator.invert)
    __lt__, __le__, __gt__, __ge__ = map(_operator, (operator.lt, operator.le, operator.gt, operator.ge))
    __eq__, __ne__ = _operator(operator.eq), _operator(operator.ne)
    __neg__, __abs__ = _unary(operator.neg), _unary(operator.abs)
