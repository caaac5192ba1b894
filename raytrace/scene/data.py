"""What is rendered: plain data. Every class here is frozen, compares by value and is a JAX pytree.

The floats are the pytree's leaves, so that an image can be differentiated with respect to any of them; the
choices (lighting, tone mapper, ...) are part of its structure. Numbers given as Python numbers and sequences
become NumPy float64 arrays; arrays, traced ones included, are kept as they are. `raytrace.check_scene` and
`raytrace.render` check the values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from raytrace.errors import InputError
from raytrace.showing import PNG

__all__ = [
    "Camera",
    "Checkerboard",
    "Film",
    "MatrixCamera",
    "OrthographicCamera",
    "PerspectiveCamera",
    "Plain",
    "Plane",
    "Scene",
    "Sky",
    "Spheres",
    "Sun",
    "concrete",
]

# Anything that NumPy takes for such an array of floats, and whatever JAX puts in its place while it traces, maps
# over a batch or takes the scene apart.
Number: TypeAlias = Any  # shape ()
Vector: TypeAlias = Any  # shape (3,)
Matrix: TypeAlias = Any  # shape (4, 4)
Numbers: TypeAlias = Any  # shape (n,)
Vectors: TypeAlias = Any  # shape (n, 3)

_STATIC = {"static": True}
NODES: list[type] = []


def _node(cls: type) -> type:
    """A frozen dataclass, and a JAX pytree; see `raytrace.scene.pytree`."""
    cls = dataclass(frozen=True, eq=False)(cls)
    NODES.append(cls)
    return cls


def _as_array(value: Any, name: str) -> Any:
    """Numbers, sequences of them and arrays of integers as float64 arrays; records, and all that is traced, as is.

    Raises:
        InputError: a sequence holds something that is no number, or that is traced.
    """
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind == "f":
        return value
    if not isinstance(value, int | float | list | tuple | np.ndarray | np.generic):
        return value
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: must be numbers, or one array (jax.numpy.array for traced ones)") from None


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or hasattr(a, "__array_namespace__"):
        return np.array_equal(a, b)
    return a == b


class _Record:
    """Conversion to arrays, and equality by value."""

    __hash__ = None

    def __post_init__(self):
        for entry in fields(self):
            if not entry.metadata.get("static"):
                object.__setattr__(self, entry.name, _as_array(getattr(self, entry.name), entry.name))

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_equal(getattr(self, entry.name), getattr(other, entry.name)) for entry in fields(self))


@_node
class Spheres(_Record):
    """An array of n spheres: centres, radii (positive) and linear RGB colours (not negative)."""

    center: Vectors = field(default_factory=lambda: np.zeros((0, 3)))
    radius: Numbers = field(default_factory=lambda: np.zeros(0))
    color: Vectors = field(default_factory=lambda: np.zeros((0, 3)))


@_node
class Checkerboard(_Record):
    """The assignment's pattern: tiles of `tile_size` in world x and z, a line in the middle of each axis."""

    tile_size: Number = 0.5
    even: Vector = (1.0, 1.0, 1.0)
    odd: Vector = (0.1, 0.1, 0.1)
    line: Vector = (1.0, 0.8, 0.4)


@_node
class Plain(_Record):
    """One linear RGB colour."""

    color: Vector


@_node
class Plane(_Record):
    """The plane through `point` with `normal`, of any length and never flipped towards the viewer.

    `casts_shadow` is an extension: in the assignment only spheres do.
    """

    point: Vector = (0.0, -0.5, 0.0)
    normal: Vector = (0.0, 1.0, 0.0)
    pattern: Checkerboard | Plain = field(default_factory=Checkerboard)
    casts_shadow: bool = field(default=False, metadata=_STATIC)


@_node
class Sun(_Record):
    """`direction` points to the sun and may have any length but 0; `color` is linear RGB, HDR."""

    direction: Vector = (1.0, 0.75, 1.0)
    color: Vector = (1.64, 1.27, 0.99)


@_node
class Sky(_Record):
    """Linear RGB colours at the horizon, overhead, and below the horizon."""

    low: Vector = (0.36, 0.45, 0.57)
    high: Vector = (0.14, 0.21, 0.49)
    void: Vector = (0.025, 0.05, 0.075)


@_node
class PerspectiveCamera(_Record):
    """The camera of ShaderLabWeb: `field_of_view` is vertical and in degrees. `near` and `far` never clip."""

    position: Vector = (0.0, 0.5, 2.0)
    target: Vector = (0.0, 0.5, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    field_of_view: Number = 60.0
    near: Number = 0.1
    far: Number = 100.0


@_node
class OrthographicCamera(_Record):
    """An extension: parallel rays from the near plane; the picture is `height` world units high."""

    height: Number
    position: Vector = (0.0, 0.5, 2.0)
    target: Vector = (0.0, 0.5, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    near: Number = 0.1
    far: Number = 100.0


@_node
class MatrixCamera(_Record):
    """The two matrices themselves, as arrays of rows: inverse projection and inverse view.

    The fourth column of `view_to_world` is the camera's position. The projection is taken for a perspective one
    and brings its own aspect ratio.
    """

    ndc_to_view: Matrix
    view_to_world: Matrix


Camera: TypeAlias = PerspectiveCamera | OrthographicCamera | MatrixCamera


@_node
class Film(_Record):
    """From linear light to display values. The defaults are the assignment's and add nothing to it.

    exposure: stops (EV); the linear image is multiplied by 2**exposure.
    white_point: the colour that is to become white, as a correlated colour temperature in kelvin
        (1667 ... 25000) or as CIE 1931 (x, y); ``None`` for no adaptation. A constant, not differentiable. Components
        that the adaptation makes negative become 0.
    tone_mapper: "aces", "reinhard", "hable", "none", or a function of a `Vec3` of linear light.
    transfer: "gamma2.2", "srgb" or "none".
    """

    exposure: Number = 0.0
    white_point: float | Sequence[float] | None = field(default=None, metadata=_STATIC)
    tone_mapper: str | Callable = field(default="aces", metadata=_STATIC)
    transfer: str = field(default="gamma2.2", metadata=_STATIC)

    def __post_init__(self):
        super().__post_init__()
        if isinstance(self.white_point, list | tuple | np.ndarray):
            object.__setattr__(self, "white_point", tuple(map(float, self.white_point)))


@_node
class Scene(_Record):
    """Everything that is rendered. The defaults are the assignment's sun, sky and film, and an empty world.

    lighting: "off" (figure 3), "on" (figure 5) or "shadow" (figure 6).
    """

    spheres: Spheres = field(default_factory=Spheres)
    planes: Sequence[Plane] = ()
    sun: Sun = field(default_factory=Sun)
    sky: Sky = field(default_factory=Sky)
    lighting: Literal["off", "on", "shadow"] = field(default="shadow", metadata=_STATIC)
    camera: Camera = field(default_factory=PerspectiveCamera)
    film: Film = field(default_factory=Film)

    def __post_init__(self):
        # Its fields are records, which have converted their own numbers.
        if isinstance(self.planes, list):
            object.__setattr__(self, "planes", tuple(self.planes))

    def _repr_png_(self) -> bytes | None:
        """Return the picture for Jupyter, or ``None``: it shows the text of a scene that is traced or wrong."""
        return PNG["scene"](self)


def concrete(record: Any) -> Any:
    """The same record with every array as a NumPy float64 array.

    Raises:
        jax.errors.TracerArrayConversionError: a value is traced.
    """
    changed = {}
    for entry in fields(record):
        value = getattr(record, entry.name)
        if isinstance(value, _Record):
            changed[entry.name] = concrete(value)
        elif entry.metadata.get("static"):
            continue
        elif isinstance(value, tuple):
            changed[entry.name] = tuple(map(concrete, value))
        else:
            changed[entry.name] = np.asarray(value, dtype=np.float64)
    return replace(record, **changed)
