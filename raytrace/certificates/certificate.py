"""A certificate: what the values of a scene's image can be."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.arithmetic.intervals import BUILT_INS, GLSL_HIGHP, REAL
from raytrace.certificates.bounds import REASONS, Bounds, image_bounds
from raytrace.errors import InputError, check_choice
from raytrace.image import read_metadata, read_planes, write_planes
from raytrace.rendering import check_size
from raytrace.scene import Scene, scene_hash, scene_toml
from raytrace.scene.to_uniforms import program_of, rounded, uniforms_of
from raytrace.scene.toml import as_scene, scene_from_toml
from raytrace.shader.pixel import Frame
from raytrace.shader.specification import SPECIFICATION, VERSIONS
from raytrace.shader.sphere import INTERSECTIONS
from raytrace.tables import html_table, text_table

__all__ = ["ASSUMPTIONS", "FORMULAS", "PRECISIONS", "Certificate", "certify", "check_specification", "read_certificate"]

PRECISIONS = {model.name: model for model in (REAL, GLSL_HIGHP)}
#: What may be asked of a GPU: either formula for the sphere, or the other, as long as it is the same at a pixel.
FORMULAS = (*INTERSECTIONS, "either")

#: What a certificate takes for granted, by precision.
ASSUMPTIONS = {
    "real": (
        "NumPy's + - * / sqrt are correctly rounded and its exp2 and log2 err by at most 4 units in the last place",
        "a quotient by zero is infinite",
    ),
    "glsl-highp": (
        "operations err by what WGSL, Vulkan and GLSL ES 3.00 promise of 32 bit floats; GLSL ES 3.00 promises less of "
        "sqrt, inversesqrt and pow, which are held to WGSL's",
        "the shader's expressions are evaluated in source order, fused multiply-add allowed; WGSL allows any order, "
        "without a bound",
        "inside a built-in any of these forms is taken, each fused or not",
        *(f"{name}: {forms}" for name, forms in BUILT_INS.items()),
        "intermediate results are finite, but for a quotient by zero, which is infinite",
        "the scene's numbers reach the shader as float32, exactly",
        "the same operations on the same numbers give the same result: coincident spheres are met at the same t",
    ),
}
_LAYERS = ("display", "linear")
_ENDS = ("low", "high")
_LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Certificate:
    """Bounds of the display and linear values of a scene's image.

    precision: "real": those of the real number that the assignment's program stands for; "glsl-highp": those of what a
        conforming GPU may print.
    intersection: the formula for the sphere, "textbook" or "robust", or "either". Real numbers do not depend on it.
    """

    scene: Scene
    precision: str
    intersection: str
    bounds: Bounds

    @property
    def size(self) -> tuple[int, int]:
        height, width = self.bounds.reason.shape
        return width, height

    @property
    def assumptions(self) -> tuple[str, ...]:
        return ASSUMPTIONS[self.precision]

    @cached_property
    def width(self) -> np.ndarray:
        """(height, width): how far a pixel's display bounds are apart, the widest of its channels."""
        low, high = self.bounds.display
        return (high - low).max(axis=-1)

    @cached_property
    def levels(self) -> tuple[np.ndarray, np.ndarray]:
        """(height, width, 3) integers: the 8 bit values of the lower and of the upper bounds."""
        low, high = self.bounds.display
        # The product is rounded; a bound at a half between two values must not be on the wrong side of it.
        low, high = 255 * low - 1e-12, 255 * high + 1e-12
        low, high = (np.clip(np.floor(end + 0.5), 0, 255).astype(np.uint8) for end in (low, high))
        return low, high

    @cached_property
    def proven(self) -> np.ndarray:
        """(height, width, 3): where there is but one 8 bit value."""
        low, high = self.levels
        return low == high

    @cached_property
    def reasons(self) -> dict[str, int]:
        """How many pixels are not proven in 8 bits, by why."""
        open_ = ~self.proven.all(axis=-1)
        counts = {name: int((open_ & (self.bounds.reason == i)).sum()) for i, name in enumerate(REASONS) if i}
        return counts | {"rounding to 8 bit": int((open_ & (self.bounds.reason == 0)).sum())}

    def rows(self) -> list[tuple[str, str]]:
        """The summary: what, and how much."""
        width, height = self.size
        formula = "" if self.precision == "real" else f", {self.intersection}"
        pixels, undecided = width * height, int((self.bounds.reason > 0).sum())
        over = self.width > 1 / 255
        return [
            ("certificate", f"{width}x{height}, precision {self.precision}{formula}"),
            ("8 bit values proven", f"{self.proven.mean():.6%}"),
            ("pixels undecided", f"{undecided} ({undecided / pixels:.4%})"),
            ("bounds over 1/255", f"{over.sum()} ({over.mean():.4%} of pixels)"),
            ("median width", f"{np.median(self.width):.2g}"),
            *(("not proven", f"{n} pixels: {why}") for why, n in self.reasons.items() if n),
            *(("assumed", text) for text in self.assumptions),
        ]

    def __str__(self) -> str:
        return text_table(self.rows())

    def _repr_html_(self) -> str:
        return html_table(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """The summary as plain types, for JSON."""
        return {
            "scene_sha256": scene_hash(self.scene),
            "size": list(self.size),
            "precision": self.precision,
            "intersection": self.intersection,
            "proven": float(self.proven.mean()),
            "undecided": int((self.bounds.reason > 0).sum()),
            "over": int((self.width > 1 / 255).sum()),
            "median_width": float(np.median(self.width)),
            "not_proven": self.reasons,
            "assumptions": list(self.assumptions),
        }

    def write(self, path: str | Path) -> None:
        """Writes an OpenEXR file: layers ``display.low.R`` ... ``linear.high.B``, float32 outward, and ``reason``.

        A linear value without a bound has float32's largest number for one. `reason` counts `REASONS`.

        Raises:
            InputError: the file is no .exr, or cannot be written.
        """
        planes = {}
        for layer in _LAYERS:
            for end, values, outward in zip(_ENDS, getattr(self.bounds, layer), (-np.inf, np.inf), strict=True):
                rounded = _float32(values, outward)
                planes |= {f"{layer}.{end}.{channel}": rounded[..., k] for k, channel in enumerate("RGB")}
        planes["reason"] = self.bounds.reason.astype(np.float32)
        metadata = {
            "certificate": "1",
            "specification": str(SPECIFICATION),
            "scene": scene_toml(self.scene),
            "scene_sha256": scene_hash(self.scene),
            "precision": self.precision,
            "intersection": self.intersection,
            "assumptions": "; ".join(self.assumptions),
            "reasons": ", ".join(f"{i} {name or 'decided'}" for i, name in enumerate(REASONS)),
            "version": version("raytrace"),
        }
        write_planes(path, planes, metadata=metadata)


def certify(
    scene: Scene | str | Path,
    size: tuple[int, int] = (480, 270),
    *,
    precision: str = "real",
    intersection: str = "either",
    done: Callable[[float], object] = lambda pixels: None,
) -> Certificate:
    """Bounds of every pixel of a scene's image, for one sample a pixel.

    precision: see `Certificate`. intersection: for "glsl-highp", which formula for the sphere the program uses.
    done: is told of pixels as they are done.

    Raises:
        InputError: an argument or a value of the scene is wrong.
    """
    check_size(size)
    check_choice("precision", precision, PRECISIONS)
    check_choice("intersection", intersection, FORMULAS)
    scene = as_scene(scene)
    width, height = size
    uniforms = rounded(uniforms_of(scene, width / height))
    # In real numbers both formulas are one, and this one's bounds are narrower.
    formulas = ("robust",) if precision == "real" else _formulas(intersection)
    found = [
        image_bounds(
            uniforms,
            program_of(scene, formula),
            Frame(width, height),
            PRECISIONS[precision],
            lambda pixels: done(pixels / len(formulas)),
        )
        for formula in formulas
    ]
    return Certificate(scene, precision, intersection, reduce(Bounds.hull, found))


def _formulas(intersection: str) -> tuple[str, ...]:
    return tuple(INTERSECTIONS) if intersection == "either" else (intersection,)


def read_certificate(path: str | Path) -> Certificate:
    """Read a certificate from a file that `Certificate.write` has written.

    Raises:
        InputError: there is no such file, it is no certificate, or it is of another specification.
    """
    path = Path(path)
    metadata, planes = read_metadata(path), read_planes(path)
    if "certificate" not in metadata or "reason" not in planes:
        raise InputError(f"{path}: is no certificate; 'raytrace certify' makes one")
    check_specification(path, "a certificate", metadata.get("specification", "1"), "raytrace certify")
    planes_of = [f"{layer}.{end}.{channel}" for layer in _LAYERS for end in _ENDS for channel in "RGB"]
    missing = [name for name in ("scene", "precision", "intersection") if name not in metadata]
    missing += [name for name in planes_of if name not in planes]
    if missing:
        raise InputError(f"{path}: the certificate lacks {', '.join(missing[:4])}")
    check_choice(f"{path}: precision", metadata["precision"], PRECISIONS)
    check_choice(f"{path}: intersection", metadata["intersection"], FORMULAS)

    def layer(name: str) -> tuple[np.ndarray, np.ndarray]:
        ends = (np.stack([planes[f"{name}.{end}.{channel}"] for channel in "RGB"], axis=-1) for end in _ENDS)
        low, high = (end.astype(np.float64) for end in ends)
        return low, high

    scene = scene_from_toml(metadata["scene"], f"{path}: the scene in its metadata")
    reason = planes["reason"].astype(np.uint8)
    bounds = Bounds(layer("display"), layer("linear"), reason, np.where(reason > 0, 2, 1).astype(np.int32))
    return Certificate(scene, metadata["precision"], metadata["intersection"], bounds)


def check_specification(path: Path, what: str, found: int | str, command: str) -> None:
    """Check that a file is of the specification that this package computes (`raytrace.shader.specification`).

    what: what the file holds. found: the version that it states. command: what makes such a file.

    Raises:
        InputError: it is of another version, older or newer, or of none.
    """
    try:
        theirs = int(found)
    except ValueError:
        raise InputError(f"{path}: specification: must be a whole number, found {found!r}") from None
    if theirs < SPECIFICATION:
        changed = "; ".join(change for number, change in VERSIONS.items() if number > theirs)
        raise InputError(
            f"{path}: {what} of specification {theirs}; this is specification {SPECIFICATION} ({changed}); "
            f"make it again with '{command}'"
        )
    if theirs > SPECIFICATION:
        raise InputError(
            f"{path}: {what} of specification {theirs}, made by a newer raytrace; "
            f"this one knows specification {SPECIFICATION}; upgrade it"
        )


def _float32(values: np.ndarray, outward: float) -> np.ndarray:
    """The float32 next to each value on the side of `outward`, -inf or inf."""
    with np.errstate(over="ignore"):
        nearest = np.clip(values, -_LARGEST, _LARGEST).astype(np.float32)
    inside = nearest > values if outward < 0 else nearest < values
    return np.clip(np.where(inside, np.nextafter(nearest, np.float32(outward)), nearest), -_LARGEST, _LARGEST)
