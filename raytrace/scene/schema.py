"""The scene file's grammar, which follows from the classes in `raytrace.scene.data`.

The models validate the plain document (dicts, lists, numbers, strings) that a TOML file is.
"""

from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from functools import reduce
from operator import or_
from typing import Annotated, Any, ClassVar, Literal, get_type_hints

import numpy as np
import pydantic
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Tag, model_validator
from pydantic_core import PydanticCustomError

from raytrace.errors import did_you_mean, unknown
from raytrace.scene.data import TAGS, Plane, Scene, Spheres, Sun
from raytrace.scene.kinds import Kind, Rule
from raytrace.scene.sun import sun_direction

__all__ = ["SceneDocument"]


def _mistake(message: str) -> PydanticCustomError:
    """The error that pydantic reports with the place where it was raised."""
    return PydanticCustomError("rule", "{message}", {"message": message})


def _wrong_key(key: str, message: str) -> PydanticCustomError:
    """A mistake of a table that belongs to one of its keys."""
    return PydanticCustomError("wrong_key", "{message}", {"key": key, "message": message})


class Table(BaseModel):
    """A table of the file. A key that it does not know is an error that names the nearest one it does."""

    model_config = ConfigDict(strict=True, frozen=True)

    #: Keys that are not a field's name, and the field.
    SPELLINGS: ClassVar[dict[str, str]] = {}

    @classmethod
    def _settled(cls, table: dict) -> dict:
        """The table by its fields' own names."""
        for key in cls.SPELLINGS.keys() & table.keys():
            if cls.SPELLINGS[key] in table:
                raise _wrong_key(key, f"is another name of {cls.SPELLINGS[key]}, which is there, too")
        return {cls.SPELLINGS.get(key, key): value for key, value in table.items()}

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, table: Any) -> Any:
        if not isinstance(table, dict | cls):
            raise _mistake("must be a table")
        if isinstance(table, dict):
            table = cls._settled(table)
        keys = table if isinstance(table, dict) else {}
        for key, tags in TAGS.items():
            if key in cls.model_fields and key in keys and keys[key] not in list(tags):
                raise _wrong_key(key, unknown(keys[key], tags))
        for key in keys:
            if key not in cls.model_fields:
                allowed = [*cls.model_fields, *cls.SPELLINGS]
                raise _wrong_key(key, f"unknown key; {did_you_mean(key, allowed, 'allowed')}")
        return table


class AngledTable(Table):
    """The sun's table: its direction may be given as two angles."""

    SPELLINGS: ClassVar[dict[str, str]] = {"azimuth": "direction", "elevation": "direction"}

    @classmethod
    def _settled(cls, table: dict) -> dict:
        angles = cls.SPELLINGS.keys() & table.keys()
        if not angles:
            return table
        if "direction" in table:
            raise _wrong_key(min(angles), "goes in place of direction, which is there, too")
        for name, most in (("azimuth", np.inf), ("elevation", 90.0)):
            angle = table.get(name)
            if angle is None:
                raise _wrong_key(name, "missing; azimuth and elevation go together")
            if isinstance(angle, bool) or not isinstance(angle, int | float) or not np.isfinite(angle):
                raise _wrong_key(name, f"must be a finite number of degrees, found {angle!r}")
            if abs(angle) > most:
                raise _wrong_key(name, f"must be from -{most:g} to {most:g} degrees, found {angle!r}")
        direction = sun_direction(float(table["azimuth"]), float(table["elevation"]))
        return {**{key: table[key] for key in table.keys() - angles}, "direction": direction.tolist()}


def _table(record: Any, base: Any = Table, **own: Any) -> Any:
    """The table of one of the scene's classes; own: types and defaults of fields that are not as they are there."""
    hints = get_type_hints(record)
    keys = {entry.name: own.pop(entry.name, None) or _key(entry, hints[entry.name]) for entry in fields(record)}

    def check(table: Table) -> Table:
        problem = record.problem(table)
        if problem is not None:
            raise _mistake(problem)
        return table

    checked = {"check": model_validator(mode="after")(check)}
    create: Any = pydantic.create_model
    table = create(f"{record.__name__}Table", __base__=base, __validators__=checked, **own, **keys)
    table.SPELLINGS = base.SPELLINGS | record.SPELLINGS
    return table


def _key(entry: Field, hint: Any) -> tuple[Any, Any]:
    """The type of a field in the file, and its default."""
    about = entry.metadata
    default = ... if entry.default is MISSING else entry.default
    if "kind" in about:
        return _numbers(about["kind"]), list(default) if isinstance(default, tuple) else default
    if "choices" in about:
        return Literal[about["choices"]], default
    if "read" in about:
        return Annotated[Any, BeforeValidator(_read(about["read"]))], default
    if entry.default is MISSING:
        table = _table(hint)
        return table, table()
    return hint, default


def _read(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def read(value: Any) -> Any:
        try:
            return function(value)
        except ValueError as error:
            raise _mistake(str(error)) from None

    return read


def _numbers(kind: Kind) -> Any:
    numbers = Annotated[float, pydantic.Field(strict=True), *map(_rule, kind.rules)]
    for length, what in zip(reversed(kind.shape), ("numbers", "rows"), strict=False):
        numbers = _list(numbers, length, what)
    return Annotated[numbers, *map(_rule, kind.together)] if kind.together else numbers


def _rule(rule: Rule) -> AfterValidator:
    def check(value: Any) -> Any:
        if not rule.holds(value):
            raise _mistake(rule.message)
        return value

    return AfterValidator(check)


def _list(item: Any, length: int, what: str) -> Any:
    def check(value: Any) -> Any:
        if not isinstance(value, list) or len(value) != length:
            raise _mistake(f"must be a list of {length} {what}")
        return value

    return Annotated[list[item], BeforeValidator(check)]


def _one_of(key: str) -> tuple[Any, Any]:
    """The type of a table that is one of several, which its `key` says; by default the first one with its defaults."""
    first, *_ = tags = TAGS[key]

    def choose(table: Any) -> str:
        # pydantic also asks it of tables already made, when it writes them. Another value the first table refuses.
        tag = table.get(key, first) if isinstance(table, dict) else getattr(table, key, first)
        return tag if tag in list(tags) else first

    tables = {tag: _table(record, **{key: (Literal[tag], tag)}) for tag, record in tags.items()}
    several = reduce(or_, (Annotated[table, Tag(tag)] for tag, table in tables.items()))
    return Annotated[several, Discriminator(choose)], tables[first]()


#: In the file each sphere is a table, all of whose numbers have to be given.
_sphere = _table(Spheres, **{entry.name: (_numbers(entry.metadata["kind"]), ...) for entry in fields(Spheres)})
_plane = _table(Plane, pattern=_one_of("type"))

_sun = _table(Sun, AngledTable)

#: The whole file.
SceneDocument = _table(
    Scene,
    spheres=(list[_sphere], []),
    planes=(list[_plane], []),
    camera=_one_of("projection"),
    sun=(_sun, _sun()),
)
