"""A scene to look around in: the picture follows the mouse, and sliders change the sun and the film.

The frames go by jupyter_rfb, which sends no more than the browser confirms, and the last one without loss.
"""

import asyncio
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import ipywidgets
import numpy as np
from jupyter_rfb import RemoteFrameBuffer

from raytrace.notebook.orbit import orbited, pivot_of, zoomed
from raytrace.rendering import render
from raytrace.scene.check import check_scene
from raytrace.scene.data import Scene
from raytrace.scene.sun import sun_angles, sun_direction
from raytrace.shader.film import TONE_MAPPERS

__all__ = ["View"]

#: Seconds without a change after which the picture is drawn sharp.
REST = 0.25
#: Seconds that a frame may take while the scene is changed: more than 20 a second are left with what the browser takes.
FRAME = 1 / 40
#: Half a turn for the picture's height, and so many pixels of the wheel for a factor of e, as in the page of `export`.
TURN, WHEEL = math.pi, 800.0


class View:
    """What `raytrace.view` gives; shows itself in Jupyter.

    scene: as it is now seen. canvas: the picture, a `jupyter_rfb.RemoteFrameBuffer`. controls: the sliders by name.
    size, coarse_size: (width, height) of the frames at rest and while something changes.
    """

    def __init__(self, scene: Scene, size: tuple[int, int], samples: int):
        check_scene(scene)
        self._scene, self.size = scene, size
        self._pivot = pivot_of(scene)
        self._rest: asyncio.TimerHandle | None = None
        self._sharp = True
        self.controls = _controls(scene, samples)
        # What is compiled now is not compiled while somebody drags.
        self.coarse_size = self._fast_size()
        self._frame(sharp=True)
        self.canvas = _Canvas(self)
        for name, control in self.controls.items():
            control.observe(lambda change, name=name: self._controlled(name), "value")
        self.widget = ipywidgets.VBox([self.canvas, ipywidgets.HBox(list(self.controls.values()), layout=_WRAP)])

    @property
    def scene(self) -> Scene:
        return self._scene

    def orbit(self, right: float, down: float) -> None:
        """Turns the scene to the right and down, in radians."""
        self._change(replace(self._scene, camera=orbited(self._scene.camera, self._pivot, right, down)))

    def zoom(self, factor: float) -> None:
        """Goes to `factor` times the distance."""
        self._change(replace(self._scene, camera=zoomed(self._scene.camera, self._pivot, factor)))

    def frame(self) -> np.ndarray:
        """The picture as it is to be shown now, uint8 (height, width, 3)."""
        return self._frame(self._sharp)

    def _ipython_display_(self) -> None:
        from IPython.display import display

        display(self.widget)

    def _frame(self, sharp: bool) -> np.ndarray:
        if sharp:
            image = render(self._scene, self.size, samples=self.controls["samples"].value)
        else:
            image = render(self._scene, self.coarse_size)
        pixels = np.rint(np.asarray(image) * 255).astype(np.uint8)
        if pixels.shape[1::-1] == self.size:
            return pixels
        rows, columns = (np.arange(n) * m // n for n, m in zip(self.size[::-1], pixels.shape[:2], strict=True))
        return pixels[rows][:, columns]

    def _fast_size(self) -> tuple[int, int]:
        """The largest of the size, its half and its quarter that can be drawn often enough."""
        size = width, height = self.size
        for divisor in (1, 2, 4):
            size = -(-width // divisor), -(-height // divisor)
            render(self._scene, size)
            # Another scene, as what is prepared of the last one is kept.
            moved = replace(self._scene, camera=orbited(self._scene.camera, self._pivot, 1e-3, 0.0))
            begun = time.perf_counter()
            np.asarray(render(moved, size))
            if time.perf_counter() - begun < FRAME:
                break
        return size

    def _change(self, scene: Scene) -> None:
        self._scene, self._sharp = scene, False
        self.canvas.request_draw()
        if self._rest is not None:
            self._rest.cancel()
        try:
            self._rest = asyncio.get_running_loop().call_later(REST, self._sharpen)
        except RuntimeError:  # nobody waits for a frame where no loop runs
            self._sharp = True

    def _sharpen(self) -> None:
        self._sharp, self._rest = True, None
        self.canvas.request_draw()

    def _controlled(self, name: str) -> None:
        scene, film, value = self._scene, self._scene.film, self.controls[name].value
        if name in ("azimuth", "elevation"):
            direction = sun_direction(self.controls["azimuth"].value, self.controls["elevation"].value)
            scene = scene.with_("sun.direction", direction)
        elif name == "exposure":
            scene = replace(scene, film=replace(film, exposure=value))
        elif name == "tone mapper":
            scene = replace(scene, film=replace(film, tone_mapper=value))
        self._change(scene)


class _Canvas(RemoteFrameBuffer):
    """The picture and what is done to it."""

    def __init__(self, view: View):
        width, height = view.size
        super().__init__(css_width=f"{width}px", css_height=f"{height}px", resizable=False, cursor="grab")
        self._shown, self._at = view, None

    def get_frame(self) -> np.ndarray:
        return self._shown.frame()

    def handle_event(self, event: dict[str, Any]) -> None:
        kind = event["event_type"]
        if kind == "pointer_down" and event["button"] == 1:
            self._at = event["x"], event["y"]
        elif kind == "pointer_up":
            self._at = None
        elif kind == "pointer_move" and self._at is not None:
            (x, y), self._at = self._at, (event["x"], event["y"])
            angle = TURN / self._shown.size[1]
            self._shown.orbit((event["x"] - x) * angle, (event["y"] - y) * angle)
        elif kind == "wheel":
            self._shown.zoom(math.exp(event["dy"] / WHEEL))


_WRAP = ipywidgets.Layout(flex_flow="row wrap")


def _controls(scene: Scene, samples: int) -> dict[str, Any]:
    azimuth, elevation = map(float, sun_angles(scene.sun.direction))
    mapper = scene.film.tone_mapper
    mappers = [*TONE_MAPPERS] if mapper in TONE_MAPPERS else [*TONE_MAPPERS, ("its own", mapper)]
    slider: Callable = ipywidgets.FloatSlider
    return {
        "azimuth": slider(azimuth, min=-180, max=180, step=0.5, description="azimuth"),
        "elevation": slider(elevation, min=-90, max=90, step=0.5, description="elevation"),
        "exposure": slider(float(scene.film.exposure), min=-8, max=8, step=0.1, description="exposure"),
        "tone mapper": ipywidgets.Dropdown(value=mapper, options=mappers, description="tone mapper"),
        "samples": ipywidgets.Dropdown(value=samples, options=[1, 2, 4, 8], description="samples"),
    }
