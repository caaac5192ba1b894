"""What is rendered: plain data. Every class here is frozen, compares by value and is a JAX pytree.

The floats are the pytree's leaves, so that an image can be differentiated with respect to any of them; the
choices (lighting, tone mapper, ...) are part of its structure. Numbers given as Python numbers and sequences
become NumPy float64 arrays; arrays, traced ones included, are kept as they are. `raytrace.check_scene` and
`raytrace.render` check the values.
"""

from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, ClassVar, TypeAlias, TypeVar

import numpy as np

from raytrace.errors import InputError, did_you_mean
from raytrace.language.namespace import namespace
from raytrace.scene.kinds import (
    ANGLE,
    COLOR,
    DIRECTION,
    EXPOSURE,
    LENGTH,
    MATRIX,
    POINT,
    SHORTEST,
    Kind,
    white_point,
)
from raytrace.scene.path import parts_of
from raytrace.scene.sun import sun_angles, sun_direction
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS
from raytrace.showing import PNG

__all__ = [
    "CAMERAS",
    "NODES",
    "PATTERNS",
    "TAGS",
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

#: A camera that looks along its own up, as far as numbers show, has no sideways; the sine of the angle between them.
LEAST_SINE = 1e-9


def _as_array(value: Any, name: str) -> Any:
    """Numbers, sequences of them and arrays of integers as float64 arrays; records, and all that is traced, as is.

    Raises:
        InputError: a sequence holds something that is not a number, or that is traced.
    """
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind == "f":
        return value
    if not isinstance(value, int | float | list | tuple | np.ndarray | np.generic):
        return value
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: must be numbers, or one array (jax.numpy.array for traced ones)") from None


def _as_constant(value: Any, name: str) -> Any:
    """A choice as Python has it: numbers of NumPy and JAX are no part of a structure, which is hashed and compared.

    Raises:
        InputError: it is traced.
    """
    if not isinstance(value, np.generic | np.ndarray) and not hasattr(value, "__array_namespace__"):
        return value
    try:
        plain = value.tolist()
    except TypeError:
        raise InputError(f"{name}: is a constant, which JAX cannot trace") from None
    return tuple(plain) if isinstance(plain, list) else plain


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or hasattr(a, "__array_namespace__"):
        return np.array_equal(a, b)
    return a == b


Record = TypeVar("Record", bound="_Record")


@dataclass(frozen=True, eq=False)
class _Record:
    """Conversion to arrays, equality by value, and copies with other values."""

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    #: Other names of fields, in paths and in files.
    SPELLINGS: ClassVar[dict[str, str]] = {}

    def problem(self) -> str | None:
        """Return what is wrong with the fields together, each of which is right; ``None`` if nothing."""
        return None

    def __post_init__(self):
        for entry in fields(self):
            convert = _as_constant if entry.metadata.get("static") else _as_array
            object.__setattr__(self, entry.name, convert(getattr(self, entry.name), entry.name))

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_equal(getattr(self, entry.name), getattr(other, entry.name)) for entry in fields(self))

    def with_(self: Record, *path_and_value: Any, **changes: Any) -> Record:
        """Return a copy with other values.

        path_and_value: a path as in a scene file, such as ``"sun.azimuth"`` or ``"spheres[0].radius"``, and the value
            there.
        changes: fields or paths, and their values. Numbers may be traced by JAX.

        Raises:
            InputError: there is no such field.
        """
        if len(path_and_value) not in (0, 2):
            raise InputError(f"with_: takes a path and its value, or name=value, found {len(path_and_value)} arguments")
        changed = self
        for path, value in [*([path_and_value] if path_and_value else []), *changes.items()]:
            parts = parts_of(path) if isinstance(path, str) else []
            if not parts:
                raise InputError(f"with_: must be given a path such as 'sun.direction', found {path!r}")
            changed = changed._changed(parts, value, path)
        return changed

    def _changed(self: Record, parts: list[str | int], value: Any, path: str) -> Record:
        """A copy with `value` where the `parts` of the `path` lead."""
        first, *rest = parts
        name = self.SPELLINGS.get(str(first), str(first))
        names = [entry.name for entry in fields(self)]
        if name not in names:
            raise InputError(f"{path}: {type(self).__name__} has no {name!r}; {did_you_mean(name, names, 'it has')}")
        return replace(self, **{name: _within(getattr(self, name), rest, value, path)})


def _within(place: Any, parts: list[str | int], value: Any, path: str) -> Any:
    """What stands at `place` once `value` is where the `parts` of the `path` lead."""
    if not parts:
        return value
    if isinstance(place, _Record):
        return place._changed(parts, value, path)
    index, *rest = parts
    if not isinstance(index, int) or not (isinstance(place, tuple) or np.ndim(place)):
        raise InputError(f"{path}: there is nothing at {index!r}")
    if index >= len(place):
        raise InputError(f"{path}: has no [{index}]; there are {len(place)}")
    changed = _within(place[index], rest, value, path)
    if isinstance(place, tuple):
        return (*place[:index], changed, *place[index + 1 :])
    # As JAX's arrays cannot be written to.
    there = np.reshape(np.arange(len(place)) == index, (-1, *[1] * (place.ndim - 1)))
    xp = namespace(changed, place)
    try:
        return xp.where(there, xp.asarray(changed), place)
    except (TypeError, ValueError):
        raise InputError(f"{path}: must be of shape {place.shape[1:]}, found {value!r}") from None


#: The classes of a scene.
NODES: list[type[_Record]] = []


def _node(cls: type[Record]) -> type[Record]:
    """Name a dataclass's fields in its docstring, and remember it: it is a JAX pytree (`raytrace.scene.pytree`)."""
    lines = [
        f"{entry.name}: {entry.metadata['words']}{of}."
        for entry in fields(cls)
        for of in [f"; {entry.metadata['kind']}" if "kind" in entry.metadata else ""]
    ]
    cls.__doc__ = "\n    ".join([f"{cls.__doc__}\n", *lines])
    NODES.append(cls)
    return cls


def _numbers(kind: Kind, words: str, default: Any = MISSING) -> Any:
    """A field of numbers of that kind."""
    return field(default=default, metadata={"kind": kind, "words": words})


def _array(kind: Kind, words: str) -> Any:
    """A field of n such numbers, by default none."""
    return field(default_factory=lambda: np.zeros((0, *kind.shape)), metadata={"kind": kind, "words": words})


def _record(words: str, default: Callable[[], Any]) -> Any:
    """A field of other records."""
    return field(default_factory=default, metadata={"words": words})


def _static(words: str, default: Any, **what: Any) -> Any:
    """A field that is a part of a scene's structure; what: its `choices`, or the function that reads it."""
    return field(default=default, metadata={"static": True, "words": words, **what})


@_node
@dataclass(frozen=True, eq=False)
class Spheres(_Record):
    """An array of n spheres: numbers of shape (n, 3), (n,) and (n, 3)."""

    center: Vectors = _array(POINT, "the centres")
    radius: Numbers = _array(LENGTH, "the radii")
    color: Vectors = _array(COLOR, "linear RGB colours")

    def _changed(self, parts: list[str | int], value: Any, path: str) -> Any:
        first, *rest = parts
        if not isinstance(first, int):
            return super()._changed(parts, value, path)
        # The path of a file, which has a table for each sphere.
        if not rest:
            raise InputError(f"{path}: must name a number of that sphere, such as {path}.radius")
        return super()._changed([*rest[:1], first, *rest[1:]], value, path)


@_node
@dataclass(frozen=True, eq=False)
class Checkerboard(_Record):
    """The assignment's pattern: tiles in world x and z, a line in the middle of each axis."""

    tile_size: Number = _numbers(LENGTH, "the side of a tile", 0.5)
    even: Vector = _numbers(COLOR, "linear RGB of one half of the tiles", (1.0, 1.0, 1.0))
    odd: Vector = _numbers(COLOR, "linear RGB of the other half", (0.1, 0.1, 0.1))
    line: Vector = _numbers(COLOR, "linear RGB of the two lines", (1.0, 0.8, 0.4))


@_node
@dataclass(frozen=True, eq=False)
class Plain(_Record):
    """One colour."""

    color: Vector = _numbers(COLOR, "linear RGB")


@_node
@dataclass(frozen=True, eq=False)
class Plane(_Record):
    """A plane, whose normal is never flipped towards the viewer."""

    point: Vector = _numbers(POINT, "a point of it", (0.0, -0.5, 0.0))
    normal: Vector = _numbers(DIRECTION, "its normal, of any length", (0.0, 1.0, 0.0))
    pattern: Checkerboard | Plain = _record("its colours", Checkerboard)
    casts_shadow: bool = _static("an extension: in the assignment only spheres cast shadows", False)


#: The assignment's.
_TOWARDS_THE_SUN, _SUNLIGHT = (1.0, 0.75, 1.0), (1.64, 1.27, 0.99)


@_node
@dataclass(frozen=True, eq=False, init=False)
class Sun(_Record):
    """The sun, infinitely far away: by its direction, or by azimuth and elevation in degrees (`sun_direction`)."""

    direction: Vector = _numbers(DIRECTION, "towards the sun, of any length", _TOWARDS_THE_SUN)
    color: Vector = _numbers(COLOR, "linear RGB, HDR", _SUNLIGHT)

    def __init__(
        self,
        direction: Vector = _TOWARDS_THE_SUN,
        color: Vector = _SUNLIGHT,
        *,
        azimuth: Number | None = None,
        elevation: Number | None = None,
    ):
        if azimuth is not None or elevation is not None:
            if direction is not _TOWARDS_THE_SUN or azimuth is None or elevation is None:
                raise InputError("sun: takes either a direction or an azimuth and an elevation")
            direction = sun_direction(azimuth, elevation)
        object.__setattr__(self, "direction", direction)
        object.__setattr__(self, "color", color)
        self.__post_init__()

    @property
    def azimuth(self) -> Number:
        """Return the azimuth in degrees: 0 is -z, 90 is +x."""
        return sun_angles(self.direction)[0]

    @property
    def elevation(self) -> Number:
        """Return the elevation in degrees: 90 is +y."""
        return sun_angles(self.direction)[1]

    def _changed(self, parts: list[str | int], value: Any, path: str) -> Any:
        if parts == ["azimuth"]:
            return replace(self, direction=sun_direction(value, self.elevation))
        if parts == ["elevation"]:
            return replace(self, direction=sun_direction(self.azimuth, value))
        return super()._changed(parts, value, path)


@_node
@dataclass(frozen=True, eq=False)
class Sky(_Record):
    """The sky's colours, linear RGB."""

    low: Vector = _numbers(COLOR, "at the horizon", (0.36, 0.45, 0.57))
    high: Vector = _numbers(COLOR, "overhead", (0.14, 0.21, 0.49))
    void: Vector = _numbers(COLOR, "below the horizon", (0.025, 0.05, 0.075))


def _misplaced(camera: Any) -> str | None:
    """What is wrong with a camera that stands at `position` and looks at `target`, or ``None``."""
    forward = np.subtract(camera.target, camera.position)
    if not forward.any():
        return "position and target must not be the same point"
    if np.linalg.norm(forward) < SHORTEST:
        return f"position and target must be at least {SHORTEST:.3g} apart"
    up = np.array(camera.up)
    if np.linalg.norm(np.cross(forward / np.linalg.norm(forward), up / np.linalg.norm(up))) < LEAST_SINE:
        return "must not look along up; choose another target or up"
    if camera.near >= camera.far:
        return f"near must be less than far, found {camera.near!r} and {camera.far!r}"
    return None


@_node
@dataclass(frozen=True, eq=False)
class PerspectiveCamera(_Record):
    """The camera of ShaderLabWeb."""

    SPELLINGS: ClassVar[dict[str, str]] = {"fov": "field_of_view"}

    position: Vector = _numbers(POINT, "where it stands", (0.0, 0.5, 2.0))
    target: Vector = _numbers(POINT, "the point in the middle of the picture", (0.0, 0.5, 0.0))
    up: Vector = _numbers(DIRECTION, "what is up in the picture", (0.0, 1.0, 0.0))
    field_of_view: Number = _numbers(ANGLE, "of the picture's height, in degrees", 60.0)
    near: Number = _numbers(LENGTH, "the distance of the near plane, which never clips", 0.1)
    far: Number = _numbers(LENGTH, "the distance of the far plane, which never clips", 100.0)

    def problem(self) -> str | None:
        return _misplaced(self)


@_node
@dataclass(frozen=True, eq=False)
class OrthographicCamera(_Record):
    """An extension: parallel rays from the near plane."""

    height: Number = _numbers(LENGTH, "of the picture, in world units")
    position: Vector = _numbers(POINT, "where it stands", (0.0, 0.5, 2.0))
    target: Vector = _numbers(POINT, "the point in the middle of the picture", (0.0, 0.5, 0.0))
    up: Vector = _numbers(DIRECTION, "what is up in the picture", (0.0, 1.0, 0.0))
    near: Number = _numbers(LENGTH, "the distance of the near plane, which never clips", 0.1)
    far: Number = _numbers(LENGTH, "the distance of the far plane, which never clips", 100.0)

    def problem(self) -> str | None:
        return _misplaced(self)


@_node
@dataclass(frozen=True, eq=False)
class MatrixCamera(_Record):
    """The two matrices themselves, as arrays of rows.

    The fourth column of `view_to_world` is the camera's position. The projection is taken for a perspective one
    and brings its own aspect ratio.
    """

    ndc_to_view: Matrix = _numbers(MATRIX, "the inverse projection")
    view_to_world: Matrix = _numbers(MATRIX, "the inverse view matrix")

    def problem(self) -> str | None:
        for name in ("ndc_to_view", "view_to_world"):
            if not np.linalg.det(getattr(self, name)):
                return f"{name} must be an invertible matrix"
        if not np.allclose(self.view_to_world[3], (0, 0, 0, 1), rtol=0, atol=1e-6):
            return "view_to_world must have 0 0 0 1 as its last row; is it transposed? The position is the last column"
        return None


Camera: TypeAlias = PerspectiveCamera | OrthographicCamera | MatrixCamera


@_node
@dataclass(frozen=True, eq=False)
class Film(_Record):
    """From linear light to display values. The defaults are the assignment's and add nothing to it."""

    exposure: Number = _numbers(EXPOSURE, "in stops (EV): the linear image is multiplied by 2**exposure", 0.0)
    white_point: float | Sequence[float] | None = _static(
        "the colour that is to become white: kelvin (1667 ... 25000) or CIE 1931 (x, y); ``None`` for no adaptation, "
        "whose negative components become 0. A constant, not differentiable",
        None,
        read=white_point,
    )
    tone_mapper: str | Callable = _static(
        f"{', '.join(TONE_MAPPERS)}, or a function of a `raytrace.shader.glsl.Vec3` of linear light",
        "aces",
        choices=tuple(TONE_MAPPERS),
    )
    transfer: str = _static(", ".join(TRANSFERS), "gamma2.2", choices=tuple(TRANSFERS))

    def __post_init__(self):
        super().__post_init__()
        if isinstance(self.white_point, list | tuple):
            object.__setattr__(self, "white_point", tuple(map(float, self.white_point)))


@_node
@dataclass(frozen=True, eq=False)
class Scene(_Record):
    """Everything that is rendered. The defaults are the assignment's sun, sky and film, and an empty world."""

    spheres: Spheres = _record("the spheres", Spheres)
    planes: Sequence[Plane] = _record("the planes", tuple)
    sun: Sun = _record("the sun", Sun)
    sky: Sky = _record("the sky", Sky)
    lighting: str = _static(
        "off (figure 3), on (figure 5) or shadow (figure 6)", "shadow", choices=("off", "on", "shadow")
    )
    camera: Camera = _record("the camera", PerspectiveCamera)
    film: Film = _record("the film", Film)

    def __post_init__(self):
        # Its fields are records, which have converted their own numbers.
        if isinstance(self.planes, list):
            object.__setattr__(self, "planes", tuple(self.planes))

    def _repr_png_(self) -> bytes | None:
        """Return the picture for Jupyter, or ``None``: it shows the text of a scene that is traced or wrong."""
        return PNG["scene"](self)


#: The keys of a scene file that choose a class, and what they can be; the first is the default.
CAMERAS = {"perspective": PerspectiveCamera, "orthographic": OrthographicCamera, "matrices": MatrixCamera}
PATTERNS = {"checkerboard": Checkerboard, "plain": Plain}
TAGS: dict[str, dict[str, type]] = {"projection": CAMERAS, "type": PATTERNS}


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
