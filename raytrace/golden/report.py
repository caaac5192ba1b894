"""The result of a check as one HTML file: a table to sort, thumbnails, and for what failed the picture of it."""

import base64
import os
from collections.abc import Sequence
from datetime import date
from html import escape
from importlib.metadata import version
from pathlib import Path
from string import Template

import numpy as np

from raytrace.comparison import Comparison, write_diff
from raytrace.files import temporary_folder, whole_file
from raytrace.golden.checking import Checked
from raytrace.image import write_image

__all__ = ["write_report"]

#: Columns of a thumbnail, at most.
_THUMBNAIL = 240
#: The difference that the thumbnail of a difference shows as white.
_WHITE = 16 / 255

_PAGE = Template("""\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
:root { color-scheme: light dark; --line: color-mix(in srgb, currentColor 20%, transparent) }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 90rem; padding: 0 1rem }
table { border-collapse: collapse; width: 100% }
th, td { padding: .4rem .6rem; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line) }
th button { font: inherit; font-weight: 600; border: 0; padding: 0; background: none; color: inherit; cursor: pointer }
th button::after { content: " \\2195"; opacity: .4 }
td.number { text-align: right; font-variant-numeric: tabular-nums }
img { display: block; max-width: 100%; height: auto }
td img { width: ${thumbnail}px; border: 1px solid var(--line) }
.ok { color: light-dark(#1a7f37, #57d27d) } .failed { color: light-dark(#c21f30, #ff8a8a); font-weight: 600 }
pre { overflow-x: auto }
</style>
<h1>$title</h1>
<p>$summary</p>
$notes
<table>
<thead><tr>$heads</tr></thead>
<tbody>
$rows
</tbody>
</table>
$details
<script>
// A click on a column's head sorts by it, a second click the other way round.
for (const head of document.querySelectorAll("th button")) head.addEventListener("click", () => {
    const cell = head.parentElement, body = cell.closest("table").tBodies[0];
    const key = row => row.cells[cell.cellIndex].dataset.key;
    const down = cell.getAttribute("aria-sort") === "ascending";
    for (const other of cell.parentElement.cells) other.removeAttribute("aria-sort");
    cell.setAttribute("aria-sort", down ? "descending" : "ascending");
    const compared = (a, b) => key(a).localeCompare(key(b), "en", {numeric: false}) || 0;
    const numeric = (a, b) => Number(key(a)) - Number(key(b));
    const order = cell.dataset.kind === "number" ? numeric : compared;
    body.append(...[...body.rows].sort((a, b) => (down ? -1 : 1) * order(a, b)));
});
</script>
""")

_HEADS = (
    ("scene", "text"),
    ("result", "text"),
    ("why", "text"),
    ("SSIM", "number"),
    ("worst window", "number"),
    ("over 1/255", "number"),
    ("largest", "number"),
    ("FLIP", "number"),
    ("golden", ""),
    ("image", ""),
    ("difference", ""),
)


def write_report(path: str | Path, results: Sequence[Checked], what: str, extra: Sequence[str] = ()) -> None:
    """Writes the report on `results`; `what` was checked, and `extra` are files that belong to no golden image.

    Raises:
        InputError: the file cannot be written.
    """
    failed = [result for result in results if result.failed]
    text = _PAGE.substitute(
        title=escape(f"{what} against golden images"),
        thumbnail=_THUMBNAIL,
        summary=f"{len(results) - len(failed)} of {len(results)} pass, those that fail first. "
        f"{date.today().isoformat()}, raytrace {version('raytrace')}, from {escape(os.getcwd())}. "
        f"A difference's white is {_WHITE * 255:g}/255.",
        notes="".join(f"<p>Extra file: {escape(name)}</p>" for name in extra),
        heads="".join(_head(*head) for head in _HEADS),
        rows="\n".join(map(_row, sorted(results, key=lambda result: not result.failed))),
        details="\n".join(map(_detail, failed)),
    )
    with whole_file(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _head(name: str, kind: str) -> str:
    return f'<th data-kind="{kind}"><button type="button">{name}</button></th>' if kind else f"<th>{name}</th>"


def _row(result: Checked) -> str:
    verdict = "failed" if result.failed else "ok"
    name = f'<a href="#{escape(result.name)}">{escape(result.name)}</a>' if result.failed else escape(result.name)
    why = escape(_why(result))
    cells = [
        f'<td data-key="{escape(result.name)}">{name}</td>',
        f'<td data-key="{verdict}" class="{verdict}">{verdict}</td>',
        f'<td data-key="{why}">{why}</td>',
    ]
    comparison = result.comparison
    if comparison is None:
        return f"<tr>{''.join(cells)}{'<td data-key=nan></td>' * (len(_HEADS) - 3)}</tr>"
    ssim = comparison.ssim
    numbers = [
        (ssim.mean if ssim else np.nan, "{:.6f}"),
        (ssim.worst if ssim else np.nan, "{:.4f}"),
        (comparison.over, "{}"),
        (comparison.largest.value, "{:.4g}"),
        (comparison.flip.mean, "{:.4g}"),
    ]
    cells += [f'<td class="number" data-key="{value}">{form.format(value)}</td>' for value, form in numbers]
    a, b = comparison.images
    pictures = (("golden", a), ("image", b), ("difference", np.abs(a - b) / _WHITE))
    cells += [
        f'<td><img alt="{what} of {escape(result.name)}" src="{_picture(image)}"></td>' for what, image in pictures
    ]
    return f"<tr>{''.join(cells)}</tr>"


def _why(result: Checked) -> str:
    """The mistake in words, where one is known, and what decided that the image fails."""
    found = None if result.comparison is None else result.comparison.diagnosis
    if not result.failed:
        return ""
    return "; ".join([*([found.sentence] if found else []), result.failed[0]])


def _detail(result: Checked) -> str:
    items = "".join(f"<li>{escape(wrong)}</li>" for wrong in result.failed)
    picture = ""
    if result.comparison is not None:
        picture = f'<pre>{escape(str(result.comparison))}</pre><img alt="" src="{_diff(result.comparison)}">'
    return f'<h2 id="{escape(result.name)}">{escape(result.name)}</h2><ul>{items}</ul>{picture}'


def _picture(image: np.ndarray) -> str:
    """A thumbnail, as a URL that holds it."""
    from skimage.transform import resize

    height, width = image.shape[:2]
    if width > _THUMBNAIL:
        image = np.asarray(
            resize(image, (max(1, round(height * _THUMBNAIL / width)), _THUMBNAIL, 3), anti_aliasing=True)
        )
    return _url(lambda path: write_image(path, np.asarray(image, np.float64)))


def _diff(comparison: Comparison) -> str:
    return _url(lambda path: write_diff(path, comparison))


def _url(write) -> str:
    with temporary_folder() as folder:
        path = folder / "image.png"
        write(path)
        return f"data:image/png;base64,{base64.b64encode(path.read_bytes()).decode()}"
