"""Whether an image is one that a conforming program can print."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from raytrace.certificates.certificate import Certificate
from raytrace.comparison.inputs import KINDS
from raytrace.comparison.wrong_storage import WHITES
from raytrace.errors import InputError, check_choice
from raytrace.image.depth import Depth, coarsest_depth, values_of
from raytrace.rendering import render
from raytrace.tables import plain

__all__ = ["PROPOSAL", "Cluster", "Verification", "proposal", "verify"]

#: Pixels outside that are this near to each other belong together.
_NEAR = 8

#: What is said of an image that keeps the bounds only if it is read otherwise than it was.
PROPOSAL = "it is inside at every pixel"


class Cluster(NamedTuple):
    """Pixels outside that lie together: how many, from (x, y) to (x, y), how far outside at most, and at which step the
    program seems to differ.
    """

    pixels: int
    first: tuple[int, int]
    last: tuple[int, int]
    by: float
    step: str

    def __str__(self) -> str:
        where = f"x {self.first[0]} to {self.last[0]}, y {self.first[1]} to {self.last[1]}"
        return f"{self.pixels} pixels, {where}, by up to {self.by:.3g}: {self.step}"


@dataclass(frozen=True)
class Verification:
    """An image beside a certificate.

    by: (height, width): how far a pixel is outside its bounds, the farthest of its channels; 0 inside.
    depth: what the image is stored as; half a unit of it is within the bounds.
    """

    certificate: Certificate
    image: np.ndarray
    by: np.ndarray
    depth: Depth

    @cached_property
    def not_finite(self) -> np.ndarray:
        """Which of the image's values, (height, width, 3), are NaN or infinite."""
        return ~np.isfinite(self.image)

    @property
    def inside(self) -> bool:
        """Whether every pixel is."""
        return not (self.by > 0).any()

    @property
    def of_8_bits(self) -> bool:
        """Whether the image is stored in 8 bits."""
        return self.depth == Depth(8)

    @cached_property
    def clusters(self) -> list[Cluster]:
        """The pixels outside, those that lie together together, the largest first."""
        from scipy import ndimage

        outside = self.by > 0
        if not outside.any():
            return []
        grown = ndimage.binary_dilation(outside, iterations=_NEAR // 2)
        labels: Any = np.zeros(grown.shape, np.int32)
        ndimage.label(grown, structure=np.ones((3, 3)), output=labels)
        steps = self._steps()
        found = []
        for i, place in enumerate(ndimage.find_objects(labels), start=1):
            mine = outside[place] & (labels[place] == i)
            ys, xs = np.nonzero(mine)
            y, x = ys + place[0].start, xs + place[1].start
            names, counts = np.unique(steps[y, x], return_counts=True)
            corner = (int(x.min()), int(y.min())), (int(x.max()), int(y.max()))
            found.append(Cluster(len(y), *corner, float(self.by[y, x].max()), str(names[counts.argmax()])))
        return sorted(found, key=lambda cluster: -cluster.pixels)

    def _steps(self) -> np.ndarray:
        """(height, width): a guess at the step that differs: what the pixel shows, or all of them where all do."""
        from scipy import ndimage

        steps = render(self.certificate.scene, self.certificate.size, backend="numpy", dtype="float64", output="steps")
        index, spheres = steps["index"], len(self.certificate.scene.spheres.radius)
        names = np.where(index < 0, "sky", np.where(index < spheres, "sphere", "ground")).astype(object)
        # In a shadow or beside one, a pixel has most likely the wrong one.
        beside = ndimage.minimum_filter(np.where(index < 0, 1, steps["shadow"]), size=3) == 0
        names[(index >= 0) & (steps["NdL"] > 0) & beside] = "shadow"
        outside = self.by > 0
        shown = {name: float(outside[names == name].mean()) for name in np.unique(names)}
        if len(shown) > 1 and min(shown.values()) > 0.5:
            names[:] = "film or camera"
        return names

    def marked(self) -> np.ndarray:
        """The image (height, width, 3), grey and darker, with the pixels outside in red, NaN and infinity in blue."""
        grey = 0.6 * np.clip(self.image, 0, 1).mean(axis=-1, keepdims=True).repeat(3, axis=-1)
        grey[self.by > 0] = (1.0, 0.1, 0.05)
        grey[self.not_finite.any(axis=-1)] = (0.1, 0.3, 1.0)
        return grey

    def __str__(self) -> str:
        pixels, outside = self.by.size, int((self.by > 0).sum())
        if self.inside:
            return f"inside at every pixel ({pixels}), precision {self.certificate.precision}"
        lines = [f"outside at {outside} of {pixels} pixels, by up to {self.by.max():.3g}"]
        if self.not_finite.any():
            y, x, channel = np.argwhere(self.not_finite)[0]
            lines.append(
                f"  {self.not_finite.sum()} of {self.image.size} values are NaN or infinite; the first one is "
                f"{self.image[y, x, channel]} at x {x}, y {y} in {('red', 'green', 'blue')[channel]}"
            )
        lines += [f"  {cluster}" for cluster in self.clusters[:8]]
        if len(self.clusters) > 8:
            lines.append(f"  and {len(self.clusters) - 8} more places")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """As plain types that strict JSON holds: what is not finite is a text."""
        return {
            "inside": self.inside,
            "outside": int((self.by > 0).sum()),
            "by": plain(float(self.by.max())),
            "not_finite": int(self.not_finite.sum()),
            "depth": str(self.depth),
            "of_8_bits": self.of_8_bits,
            "clusters": [cluster._asdict() | {"by": plain(cluster.by)} for cluster in self.clusters],
            "certificate": self.certificate.to_dict(),
        }


def verify(image: Any, certificate: Certificate, values: str = "display", depth: Depth | None = None) -> Verification:
    """Check whether every pixel of `image` keeps the certificate's bounds.

    image: (height, width, 3): floats, with 1 for white, or unsigned integers, with their largest for white.
    values: "display" or "linear", what the image holds.
    depth: what the image was stored as, `raytrace.image.read_depth` of its file. Its values have been rounded to that,
        so half a unit of it is added to the bounds. ``None`` for an array: the coarsest depth that its values can have
        been stored with (`raytrace.image.depth.coarsest_depth`), half a unit of float32 for any float32.

    NaN is outside by infinity.

    Raises:
        InputError: the image is of another shape or type, or there are no such values.
    """
    check_choice("values", values, KINDS)
    given = np.asarray(image)
    width, height = certificate.size
    if given.shape != (height, width, 3):
        raise InputError(f"image: must be of shape {(height, width, 3)}, as the certificate is, found {given.shape}")
    depth = depth or coarsest_depth(given)
    image = values_of(given)
    low, high = getattr(certificate.bounds, values)
    # The numbers that may have been stored as the image's values, and those that a program may compute, must meet.
    least, most = depth.numbers(image)
    with np.errstate(invalid="ignore"):
        by = np.maximum(low - most, least - high).max(axis=-1)
    return Verification(certificate, image, np.where(np.isnan(by), np.inf, np.maximum(by, 0)), depth)


def proposal(image: Any, certificate: Certificate, kind: str, depth: Depth | None) -> str | None:
    """Return how an image that is outside has to be read, or should have been stored, to be inside; see `verify`.

    kind: what it was taken for. ``None`` if nothing of that kind explains it.
    """
    if kind == "linear" and verify(image, certificate, "display", depth).inside:
        return f"as display values {PROPOSAL}: give --display"
    depth = depth or coarsest_depth(image)
    values = values_of(image)
    low, high = certificate.bounds.display
    if not depth.floating and ((values + depth.unit >= low) & (values - 1e-6 * depth.unit <= high)).all():
        return f"as values that were cut off {PROPOSAL}: round them to {depth}, as {depth.rounding} does"
    for white in WHITES:
        if values.max() > 0.2 * white:
            # A file of such values has whole ones, often, which are rounded by half of one.
            scaled, slack = values / white, 0.5 / white
            if ((scaled + slack >= low) & (scaled - slack <= high)).all():
                return f"with {white} for white {PROPOSAL}: store values from 0 to 1"
    return None
