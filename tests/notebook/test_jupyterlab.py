"""`raytrace.view` in JupyterLab, in a browser."""

import os
import re
import sys
import time
from base64 import b64decode

import numpy as np
import pytest

import raytrace
from tests.engines import skip_unless_required
from tests.processes import started

pytestmark = [pytest.mark.full]

SIZE = (320, 180)
CELLS = [
    f"import raytrace\nseen = raytrace.view('spheres', {SIZE}, samples=1)\nseen",
    "raytrace.save_scene(seen.scene, 'seen.toml')\nprint('saved', 'now')",
]


@pytest.fixture
def lab(tmp_path):
    """JupyterLab in a folder with one notebook; gives the notebook's address."""
    try:
        import jupyter_rfb  # noqa: F401
        import jupyterlab  # noqa: F401
    except ImportError:
        skip_unless_required(ImportError("needs JupyterLab: pip install 'raytrace[notebooks]'"))
    import nbformat

    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    book.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(book, tmp_path / "look.ipynb")
    log = tmp_path / "lab.log"
    arguments = ["--no-browser", "--allow-root", "--ServerApp.token=a", "--ServerApp.ip=127.0.0.1", "--port=0"]
    settings = {
        name: str(tmp_path / name) for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR")
    }
    command = [sys.executable, "-m", "jupyterlab", *arguments]
    with (
        log.open("w") as output,
        started(command, cwd=tmp_path, stderr=output, env=os.environ | settings) as server,
    ):
        yield f"{_address(log, server)}/lab/tree/look.ipynb?token=a"
        server.terminate()
        server.wait(20)


def _address(log, server):
    for _ in range(300):
        found = re.search(r"http://127\.0\.0\.1:\d+", log.read_text())
        if found:
            return found[0]
        assert server.poll() is None, log.read_text()
        time.sleep(0.2)
    raise AssertionError(log.read_text())


@pytest.fixture
def page(browser):
    context = browser.new_context(viewport={"width": 1200, "height": 900})
    page = context.new_page()
    # On a busy machine JupyterLab may ask something first, such as whether to wait for the kernel.
    dialog = page.locator("dialog.jp-Dialog")
    page.add_locator_handler(dialog.first, lambda asked: asked.locator("button.jp-mod-accept").first.click())
    yield page
    context.close()


def run(page, number):
    """Run a cell, once the notebook listens: a key that is pressed while it is being built is lost."""
    cell = page.locator(".jp-CodeCell").nth(number)
    has_begun = cell.locator(".jp-InputPrompt").filter(has_not_text="[ ]")
    for _ in range(10):
        cell.locator(".cm-content").click()
        page.keyboard.press("Shift+Enter")
        for _ in range(10):
            if has_begun.count():
                return
            time.sleep(0.5)
    raise AssertionError(f"cell {number} does not run")


class Picture:
    """The picture of the view as the browser has it."""

    PIXELS = """image => {
        const canvas = document.createElement("canvas");
        [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
        canvas.getContext("2d").drawImage(image, 0, 0);
        return canvas.toDataURL("image/png");
    }"""

    def __init__(self, page, folder):
        self.page, self.path = page, folder / "picture.png"
        self.image = page.locator("img.renderview-view").first

    def pixels(self):
        """Once it does not change any more: at rest it is drawn again, and sent without loss."""
        last = ""
        for _ in range(40):
            time.sleep(1)
            if last == (last := self.image.evaluate(self.PIXELS)):
                break
        self.path.write_bytes(b64decode(last.partition(",")[2]))
        return raytrace.read_image(self.path)[..., :3]

    def drag(self, right, down):
        box = self.image.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + right, y + down, steps=6)
        self.page.mouse.up()


def drawn(scene):
    return raytrace.render(scene, SIZE, backend="numpy", dtype="float64")


def share_that_differs(a, b):
    return np.mean(np.abs(a - b).max(-1) > 1.5 / 255)


def test_the_picture_follows_the_mouse(lab, page, tmp_path):
    page.goto(lab)
    page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for(timeout=120_000)
    run(page, 0)
    picture = Picture(page, tmp_path)
    picture.image.wait_for(timeout=120_000)
    before = picture.pixels()
    assert share_that_differs(before, drawn("spheres")) < 0.002

    picture.drag(50, 20)
    after = picture.pixels()
    run(page, 1)
    page.get_by_text("saved now").wait_for(timeout=60_000)
    seen = raytrace.load_scene(tmp_path / "seen.toml")
    assert share_that_differs(after, before) > 0.1
    assert share_that_differs(after, drawn(seen)) < 0.002
