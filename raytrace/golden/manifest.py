"""What a folder of golden images holds: the file ``manifest.json``."""

import hashlib
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from raytrace.errors import InputError
from raytrace.files import reason
from raytrace.image.reading import check_pixels

__all__ = ["MANIFEST", "Entry", "Manifest", "file_hash", "read_manifest"]

MANIFEST = "manifest.json"


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Entry(_Model):
    """One scene: what it is there for, its TOML, that text's SHA-256, and the SHA-256 of each of its files.

    proven: the share of the PNG's values that are proven; ``None`` without a certificate.
    """

    about: str
    toml: str
    sha256: str
    files: dict[str, str]
    proven: float | None = None


class Manifest(_Model):
    """All scenes by name, the images' size in pixels, and the versions that made them.

    specification: the version of what is computed (`raytrace.shader.specification`); manifests of version 1 do not
        state it.
    """

    format: Literal[1] = 1
    specification: int = 1
    size: tuple[int, int]
    versions: dict[str, str]
    scenes: dict[str, Entry]


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of a folder, whatever specification it is of.

    Raises:
        InputError: the folder has none, or it is broken.
    """
    path = folder / MANIFEST
    try:
        manifest = Manifest.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        raise InputError(f"{folder}: holds no golden images (no {MANIFEST}); 'raytrace golden' makes them") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise InputError(f"{path}: broken{f' at {place}' if place else ''}: {first['msg']}") from None
    if min(manifest.size) < 1:
        raise InputError(f"{path}: size: must be (width, height) of at least 1 pixel, found {manifest.size}")
    check_pixels(f"{path}: size", *manifest.size)
    return manifest


def file_hash(path: Path) -> str:
    """The SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
