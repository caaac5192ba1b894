"""The comparison of two images: `compare`, and what it gives."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison import metrics
from raytrace.comparison.diagnosis import Diagnosis, diagnosis
from raytrace.comparison.inputs import comparable
from raytrace.comparison.reference import Reference
from raytrace.comparison.regions import Part, regions
from raytrace.comparison.wrong_storage import storage_mistake
from raytrace.image import Depth
from raytrace.scene import Scene
from raytrace.tables import html_table, plain, text_table

__all__ = ["Comparison", "compare"]


@dataclass(frozen=True)
class Comparison:
    """How far two images are apart, in display values. Prints as a table, in a notebook too.

    names, size: of the images; (width, height).
    depth: the coarser one's, to which the other was rounded; ``None`` where neither is coarser than float32.
    ssim: ``None`` where it is undefined, of images under 11 x 11.
    psnr: in decibels, infinite for equal images; rmse and largest: absolute differences.
    over: the number of pixels that differ by more than 1/255 in any channel; share: of all pixels.
    delta_e, flip: CIEDE2000 and FLIP.
    searched: whether mistakes were sought: but for those in how values are stored, they are not where no pixel differs
        by more than 1/255.
    diagnosis: the mistake that was found, if any; see `raytrace.comparison.diagnosis`.
    regions: the pixels over 1/255 by parts of the scene; empty where no scene is known or no pixel is over.
    images: the display values, float64 (height, width, 3).
    reference: which of the two is the right one, "a" or "b": the other one's mistake is sought.
    """

    names: tuple[str, str]
    size: tuple[int, int]
    depth: Depth | None
    ssim: metrics.Similarity | None
    psnr: float
    rmse: float
    largest: metrics.Spot
    over: int
    delta_e: metrics.Spread
    flip: metrics.Flip
    searched: bool
    diagnosis: Diagnosis | None
    regions: tuple[Part, ...]
    images: tuple[np.ndarray, np.ndarray] = field(repr=False, compare=False)
    reference: str = "a"

    @property
    def share(self) -> float:
        return self.over / (self.size[0] * self.size[1])

    def to_dict(self) -> dict[str, Any]:
        """Everything but the images, as plain types that strict JSON holds: what is not finite is a text."""
        return {
            "a": self.names[0],
            "b": self.names[1],
            "reference": self.reference,
            "size": list(self.size),
            "depth": None if self.depth is None else str(self.depth),
            "ssim": plain(self.ssim),
            "psnr": plain(self.psnr),
            "rmse": self.rmse,
            "largest": plain(self.largest),
            "over": self.over,
            "share": self.share,
            "delta_e": plain(self.delta_e),
            "flip": plain(self.flip),
            "searched": self.searched,
            "diagnosis": plain(self.diagnosis),
            "regions": [plain(region) for region in self.regions],
        }

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), indent=1, allow_nan=False)

    def rows(self) -> list[tuple[str, str]]:
        """The table: what, and how much."""
        width, height = self.size
        worst = self.largest
        similarity = f"undefined: under {metrics.WINDOW}x{metrics.WINDOW}"
        if self.ssim is not None:
            mean, lowest, x, y = self.ssim
            similarity = f"{mean:.6f}, worst window {lowest:.6f} at x {x}, y {y}"
        return [
            *(
                (letter.upper(), f"{name}{', the reference' if letter == self.reference else ''}")
                for letter, name in zip("ab", self.names, strict=True)
            ),
            ("size", f"{width}x{height}" + (f", {self.depth} a channel" if self.depth else "")),
            ("SSIM", similarity),
            ("PSNR", f"{self.psnr:.2f} dB"),
            ("RMSE", f"{self.rmse:.4g}"),
            ("largest", f"{worst.value:.4g} at x {worst.x}, y {worst.y} in {worst.channel}"),
            ("over 1/255", f"{self.over} of {width * height} pixels, {100 * self.share:.4g} %"),
            ("CIEDE2000", f"mean {self.delta_e.mean:.4g}, 99.9th percentile {self.delta_e.p999:.4g}"),
            (
                "FLIP",
                f"mean {self.flip.mean:.4g}, 99.9th percentile {self.flip.p999:.4g}, "
                f"at {self.flip.pixels_per_degree:.2f} pixels per degree",
            ),
            *([("mistake", self._mistake())] if self.searched else []),
            *((part.name, f"{part.over:>7} of {part.pixels:>7} pixels over 1/255") for part in self.regions),
        ]

    def _mistake(self) -> str:
        if self.diagnosis is not None:
            return str(self.diagnosis)
        hint = "" if self.regions else "; with a scene, shifts of half a pixel can be told, too"
        return f"none of the usual ones explains the difference{hint}"

    def __str__(self) -> str:
        return text_table(self.rows())

    def _repr_html_(self) -> str:
        return html_table(self.rows())


def compare(
    a: Any,
    b: Any,
    *,
    scene: Scene | str | Path | None = None,
    size: tuple[int, int] = (1920, 1080),
    names: tuple[str, str] | None = None,
    kinds: tuple[str | None, str | None] = (None, None),
    diagnose: bool = True,
    layer: str | None = None,
    reference: str | None = None,
) -> Comparison:
    """Return how far two images are apart, and by which mistake of the one that is not the reference.

    Where one image is stored more coarsely than the other (8, 10 or 16 bits, half floats), the other is rounded to that
    first. A file says what it is stored as; an array's type does, and floats that are all k / 255 are of 8 bits.

    a, b: arrays (height, width, 3) of floats or unsigned integers; paths of image files; or texts ``backend:NAME`` and
        ``backend:NAME:DTYPE`` for `scene` rendered at `size`. Of a file of steps its display values are taken.
    scene: whose film develops linear light, and whose parts tell where the difference lives; otherwise the one that
        a file of `raytrace render` has in its metadata, A's first.
    names: otherwise the paths, or "A" and "B".
    kinds: "display" or "linear" for the values of each; otherwise what a file's metadata, and without them its
        ending, says; an array is "display".
    diagnose: whether to seek the usual mistakes, and the parts of the scene, where a pixel is over 1/255.
    layer: which layer, or part, of an OpenEXR file is meant, if it has several with red, green and blue.
    reference: "a" or "b", the one that is right. By default what a backend renders, or else the only file that
        `raytrace render` or `raytrace golden` has written, or else A.

    Raises:
        raytrace.compare.NotFinite: an image holds NaN or infinity; an InputError, too.
        InputError: an image is missing or of another size, or linear light without a scene.
    """
    images, depth, names, known, reference = comparable((a, b), names, kinds, scene, size, layer, reference)
    given, wrong = images, names[1]
    if reference == "b":
        images, wrong = (images[1], images[0]), names[0]
    over = metrics.pixels_over(*images)
    height, width = over.shape
    stored = storage_mistake(*images, depth) if diagnose else None
    search = diagnose and (stored is not None or bool(over.any()))
    truth = Reference(known, width, height) if search and known is not None else None
    found = stored or (diagnosis(*images, truth) if search else None)
    return Comparison(
        names=names,
        size=(width, height),
        depth=depth,
        ssim=metrics.similarity(*images),
        psnr=metrics.psnr(*images),
        rmse=metrics.rmse(*images),
        largest=metrics.largest_difference(*images),
        over=int(np.count_nonzero(over)),
        delta_e=metrics.delta_e(*images),
        flip=metrics.flip(*images),
        searched=search,
        diagnosis=None if found is None else found._replace(name=wrong),
        regions=() if truth is None else regions(over, truth),
        images=given,
        reference=reference,
    )
