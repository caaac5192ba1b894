"""The scene file's grammar, which follows from the classes in `raytrace.scene.data`.

The models validate the plain document (dicts, lists, numbers, strings) that a TOML file is.
"""

from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal, get_type_hints

import pydantic
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Tag, model_validator
from pydantic_core import PydanticCustomError

from raytrace.errors import did_you_mean, unknown
from raytrace.scene.data import TAGS, Plane, Scene, Spheres
from raytrace.scene.kinds import Kind, Rule

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

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, table: Any) -> Any:
        if not isinstance(table, dict | cls):
            raise _mistake("must be a table")
        keys = table if isinstance(table, dict) else {}
        for key, tags in TAGS.items():
            if key in cls.model_fields and key in keys and keys[key] not in list(tags):
                raise _wrong_key(key, unknown(keys[key], tags))
        for key in keys:
            if key not in cls.model_fields:
                raise _wrong_key(key, f"unknown key; {did_you_mean(key, cls.model_fields, 'allowed')}")
        return table


def _table(record: Any, **own: Any) -> Any:
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
    return create(f"{record.__name__}Table", __base__=Table, __validators__=checked, **own, **keys)


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

#: The whole file.
SceneDocument = _table(Scene, spheres=(list[_sphere], []), planes=(list[_plane], []), camera=_one_of("projection"))
