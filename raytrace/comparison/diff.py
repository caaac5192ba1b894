"""The comparison as a picture: both images, and where they differ."""

from pathlib import Path
from typing import Any

import numpy as np

from raytrace.comparison.metrics import LEVEL
from raytrace.comparison.result import Comparison
from raytrace.files import check_figure, save_figure

__all__ = ["write_diff"]

#: Worst spots that are marked.
_SPOTS = 3
#: Inches of the picture's width, and dots of an inch.
_WIDTH, _DOTS = 11, 130


def write_diff(path: str | Path, comparison: Comparison) -> None:
    """Writes A, B and the map of their largest channel's difference, in steps of 1/255, as a PNG file.

    The worst spots are ringed and numbered in all three, worst first; the colours are logarithmic from 1/255 on.

    Raises:
        InputError: the file's ending is not .png, or it cannot be written.
    """
    check_figure(path, (".png",))
    save_figure(_figure(comparison), path, _DOTS)


def _figure(comparison: Comparison) -> Any:
    from matplotlib.figure import Figure

    a, b = comparison.images
    steps = 255 * np.abs(a - b).max(axis=-1)
    height, width = steps.shape
    # Two images side by side over one of twice their width; very tall ones are not drawn to scale.
    figure = Figure(figsize=(_WIDTH, min(2 * _WIDTH, 1.2 + 1.3 * _WIDTH * height / width)), layout="constrained")
    axes = figure.subplot_mosaic([["a", "b"], ["difference", "difference"]], height_ratios=[1, 1.8])
    for name, image, title in zip("ab", (a, b), comparison.names, strict=True):
        axes[name].imshow(np.clip(image, 0, 1))
        axes[name].set_title(f"{name.upper()}: {title}", fontsize=10, parse_math=False)
    _difference(figure, axes["difference"], steps)
    for axis in axes.values():
        axis.set_xticks([])
        axis.set_yticks([])
        _mark(axis, steps)
    axes["difference"].set_title(_summary(comparison), fontsize=10, parse_math=False)
    return figure


def _difference(figure: Any, axis: Any, steps: np.ndarray) -> None:
    from matplotlib.colors import LogNorm

    shown = axis.imshow(steps, cmap="inferno", norm=LogNorm(1, max(255.0, float(steps.max())), clip=True))
    bar = figure.colorbar(shown, ax=axis, ticks=[1, 2, 5, 10, 20, 50, 100, 255], format="%d", fraction=0.03, pad=0.01)
    bar.ax.minorticks_off()
    bar.set_label("largest difference of a channel, in 1/255")


def _mark(axis: Any, steps: np.ndarray) -> None:
    """A ring around each of the worst spots, and its number."""
    from matplotlib.patches import Circle
    from matplotlib.patheffects import withStroke

    radius = max(2.0, max(steps.shape) / 40)
    outline = [withStroke(linewidth=3, foreground="black")]
    for number, (x, y) in enumerate(_worst(steps, int(2 * radius)), start=1):
        axis.add_patch(Circle((x, y), radius, fill=False, color="cyan", linewidth=1.3, path_effects=outline))
        axis.annotate(
            str(number), (x + radius, y - radius), color="cyan", fontsize=9, path_effects=outline, annotation_clip=True
        )


def _worst(steps: np.ndarray, apart: int) -> list[tuple[int, int]]:
    """Columns and rows of the largest differences over 1/255, that far apart, the largest first."""
    from skimage.feature import peak_local_max

    peaks = peak_local_max(steps, min_distance=apart, threshold_abs=255 * LEVEL, num_peaks=_SPOTS, exclude_border=False)
    return [(int(x), int(y)) for y, x in peaks]


def _summary(comparison: Comparison) -> str:
    similarity = "undefined" if comparison.ssim is None else f"{comparison.ssim.mean:.6f}"
    over = f"{comparison.over} pixels over 1/255 ({100 * comparison.share:.3g} %)"
    mistake = "" if comparison.diagnosis is None else f"\n{comparison.diagnosis.sentence}"
    return f"SSIM {similarity}, RMSE {comparison.rmse:.4g}, FLIP {comparison.flip.mean:.4g}, {over}{mistake}"
