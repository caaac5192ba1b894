"""The scene file's grammar: which keys there are and which values they take.

The models validate the plain document (dicts, lists, numbers, strings) that a TOML file is. Its defaults are
those of the classes in `raytrace.scene.data`.
"""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from raytrace.errors import did_you_mean
from raytrace.scene import data
from raytrace.scene.rules import (
    ANGLE,
    COORDINATE,
    EXPOSURE,
    INTENSITY,
    NUMBER,
    POSITIVE,
    SHORTEST,
    Rule,
    mistake,
)
from raytrace.shader.film import TONE_MAPPERS, TRANSFERS

__all__ = ["SceneDocument"]


def _number(rules: tuple[Rule, ...]) -> Any:
    return Annotated[float, Field(strict=True), *map(AfterValidator, rules)]


def _list(item: Any, length: int, what: str) -> Any:
    def check(value: Any) -> Any:
        if not isinstance(value, list) or len(value) != length:
            raise mistake(f"must be a list of {length} {what}")
        return value

    return Annotated[list[item], BeforeValidator(check)]


def _not_zero(vector: list[float]) -> list[float]:
    if not any(vector):
        raise mistake("must not be the zero vector")
    return vector


def _white_point(value: Any) -> Any:
    """A temperature in kelvin, or the pair (x, y)."""
    if isinstance(value, list | tuple) and len(value) == 2:
        if all(isinstance(v, int | float) and v > 0 for v in value) and sum(value) < 1:
            return tuple(map(float, value))
    elif isinstance(value, int | float) and not isinstance(value, bool) and 1667 <= value <= 25000:
        return float(value)
    raise mistake("must be a temperature from 1667 to 25000 kelvin or CIE [x, y] with x > 0, y > 0, x + y < 1")


Positive = _number(POSITIVE)
Angle = _number(ANGLE)
Exposure = _number(EXPOSURE)
Point = _list(_number(COORDINATE), 3, "numbers")
Color = _list(_number(INTENSITY), 3, "numbers")
Direction = Annotated[_list(_number(NUMBER), 3, "numbers"), AfterValidator(_not_zero)]
Matrix = _list(_list(_number(COORDINATE), 4, "numbers"), 4, "rows")
WhitePoint = Annotated[Any, BeforeValidator(_white_point)]


#: The keys that choose among the tables of a union, and their values.
_TAGS = {"projection": ("perspective", "orthographic", "matrices"), "type": ("checkerboard", "plain")}


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
            raise mistake("must be a table")
        keys = table if isinstance(table, dict) else {}
        for key, tags in _TAGS.items():
            if key in cls.model_fields and key in keys and keys[key] not in tags:
                raise _wrong_key(key, f"unknown {keys[key]!r}; {did_you_mean(keys[key], tags, 'there is')}")
        for key in keys:
            if key not in cls.model_fields:
                raise _wrong_key(key, f"unknown key; {did_you_mean(key, cls.model_fields, 'allowed')}")
        return table


def _defaults(record: Any) -> Any:
    """Gives the fields of a table the defaults of `record`, as plain numbers."""

    def plain(name: str) -> Any:
        value = getattr(record, name)
        return value.tolist() if isinstance(value, np.ndarray) else value

    return plain


def _by(key: str) -> Discriminator:
    """Chooses among the tables of a union by `key`; another value is left to the first table to refuse."""
    tags = _TAGS[key]
    default = tags[0]

    def choose(table: Any) -> str:
        # pydantic also asks it of tables already made, when it writes them.
        tag = table.get(key, default) if isinstance(table, dict) else getattr(table, key, default)
        return tag if tag in list(tags) else default

    return Discriminator(choose)


class SphereTable(Table):
    center: Point
    radius: Positive
    color: Color


_checkerboard = _defaults(data.Checkerboard())


class CheckerboardTable(Table):
    type: Literal["checkerboard"] = "checkerboard"
    tile_size: Positive = _checkerboard("tile_size")
    even: Color = _checkerboard("even")
    odd: Color = _checkerboard("odd")
    line: Color = _checkerboard("line")


class PlainTable(Table):
    type: Literal["plain"]
    color: Color


_plane = _defaults(data.Plane())


class PlaneTable(Table):
    point: Point = _plane("point")
    normal: Direction = _plane("normal")
    pattern: Annotated[
        Annotated[CheckerboardTable, Tag("checkerboard")] | Annotated[PlainTable, Tag("plain")],
        _by("type"),
    ] = CheckerboardTable()
    casts_shadow: bool = _plane("casts_shadow")


_sun = _defaults(data.Sun())


class SunTable(Table):
    direction: Direction = _sun("direction")
    color: Color = _sun("color")


_sky = _defaults(data.Sky())


class SkyTable(Table):
    low: Color = _sky("low")
    high: Color = _sky("high")
    void: Color = _sky("void")


_camera = _defaults(data.PerspectiveCamera())


class PlacedCamera(Table):
    """What the perspective and the orthographic camera share."""

    position: Point = _camera("position")
    target: Point = _camera("target")
    up: Direction = _camera("up")
    near: Positive = _camera("near")
    far: Positive = _camera("far")

    @model_validator(mode="after")
    def _sees(self):
        forward = np.subtract(self.target, self.position)
        if not forward.any():
            raise mistake("position and target must not be the same point")
        if np.linalg.norm(forward) < SHORTEST:
            raise mistake(f"position and target must be at least {SHORTEST:.3g} apart")
        up = np.array(self.up)
        sine = np.linalg.norm(np.cross(forward / np.linalg.norm(forward), up / np.linalg.norm(up)))
        if sine < 1e-9:
            raise mistake("must not look along up; choose another target or up")
        if self.near >= self.far:
            raise mistake(f"near must be less than far, found {self.near!r} and {self.far!r}")
        return self


class PerspectiveTable(PlacedCamera):
    projection: Literal["perspective"] = "perspective"
    field_of_view: Angle = _camera("field_of_view")


class OrthographicTable(PlacedCamera):
    projection: Literal["orthographic"]
    height: Positive


class MatricesTable(Table):
    projection: Literal["matrices"]
    ndc_to_view: Matrix
    view_to_world: Matrix

    @model_validator(mode="after")
    def _invertible(self):
        for name in ("ndc_to_view", "view_to_world"):
            if not np.linalg.det(getattr(self, name)):
                raise mistake(f"{name} must be an invertible matrix")
        return self


_film = _defaults(data.Film())


class FilmTable(Table):
    exposure: Exposure = _film("exposure")
    white_point: WhitePoint = _film("white_point")
    tone_mapper: Literal[tuple(TONE_MAPPERS)] = _film("tone_mapper")
    transfer: Literal[tuple(TRANSFERS)] = _film("transfer")


_scene = _defaults(data.Scene())


class SceneDocument(Table):
    """The whole file."""

    lighting: Literal["off", "on", "shadow"] = _scene("lighting")
    camera: Annotated[
        Annotated[PerspectiveTable, Tag("perspective")]
        | Annotated[OrthographicTable, Tag("orthographic")]
        | Annotated[MatricesTable, Tag("matrices")],
        _by("projection"),
    ] = PerspectiveTable()
    sun: SunTable = SunTable()
    sky: SkyTable = SkyTable()
    film: FilmTable = FilmTable()
    planes: list[PlaneTable] = []
    spheres: list[SphereTable] = []
