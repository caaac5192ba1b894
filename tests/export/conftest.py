"""A browser with exported pages in it."""

import re
from pathlib import Path

import numpy as np
import pytest

import raytrace
from raytrace.export import EXPORTS

#: Of the picture, and of the window, whose width it takes.
SIZE = (320, 180)
SMALL = (160, 90)


class Shown:
    """An exported scene in a browser."""

    def __init__(self, page, folder):
        self.page, self.folder = page, folder

    def settle(self):
        """Waits for the next picture."""
        self.page.evaluate("new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(drawn)))")

    def pixels(self):
        """The canvas as it is on the screen: (height, width, 3) from 0 to 1."""
        self.settle()
        self.page.locator("canvas").screenshot(path=self.folder / "canvas.png")
        return raytrace.read_image(self.folder / "canvas.png")

    def toml(self):
        """The scene's text, as the page gives it now."""
        self.settle()
        return self.page.input_value("#toml")

    def copied(self):
        """The scene that the page gives, and the size of its picture, read from its first line."""
        text = self.toml()
        size = re.match(r"# raytrace render view\.toml --size (\d+)x(\d+)\n", text)
        path = self.folder / "view.toml"
        path.write_text(text, encoding="utf-8")
        return raytrace.load_scene(path), (int(size[1]), int(size[2]))

    def rendered(self, output="display"):
        """What NumPy makes of that."""
        scene, size = self.copied()
        return raytrace.render(scene, size, backend="numpy", dtype="float64", output=output)

    def drag(self, right, down):
        """By so many pixels, in a few movements."""
        mouse = self.page.mouse
        mouse.move(100, 90)
        mouse.down()
        mouse.move(100 + right, 90 + down, steps=3)
        mouse.up()

    def slide(self, name, value):
        self.page.fill(f"#{name}", str(value))


@pytest.fixture
def show(browser):
    """Opens the page of a scene. In the end no page has asked for anything but its file, or complained.

    `script` runs before the page's own; `permissions` and the like are those of the browser's context.
    """
    contexts, asked, complaints = [], [], []

    def opened(scene="checkerboard", script="", size=SIZE, **options):
        folder = Path.cwd()
        path = folder / "page.html"
        scene = raytrace.load_scene(scene) if isinstance(scene, str) else scene
        path.write_text(EXPORTS["html"](scene, size), encoding="utf-8")
        context = browser.new_context(viewport={"width": size[0], "height": 800}, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("request", lambda request: asked.append((request.url, path.as_uri())))
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.add_init_script(script)
        page.goto(path.as_uri())
        return Shown(page, folder)

    yield opened
    for context in contexts:
        context.close()
    assert asked
    assert all(url == file for url, file in asked)
    assert complaints == []


def differing(image, reference):
    """In how many pixels they are further apart than 2/255."""
    assert image.shape == reference.shape
    return int((np.abs(image - reference).max(axis=-1) > 2.01 / 255).sum())
