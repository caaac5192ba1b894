"""From a scene to an image: `render`, and `Rendering` for images that are written while they are rendered."""

from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from raytrace.backends import BACKENDS, renderer
from raytrace.backends.job import ForeignShader, Job
from raytrace.errors import InputError, did_you_mean
from raytrace.glsl.source import read_shader
from raytrace.language.control import Engine
from raytrace.scene.check import check_scene, check_structure, is_traced
from raytrace.scene.data import Scene, concrete
from raytrace.scene.toml import DEFAULT_SCENE, load_scene, scene_hash, scene_toml
from raytrace.scene.uniforms import program_of, uniforms_of
from raytrace.shader.light import SHADOW_STARTS
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.shader.sphere import INTERSECTIONS

__all__ = ["Rendering", "check_size", "render"]

#: Means over a pixel: of samples, or of what is on either side of its edges.
ANTIALIAS = ("none", "edges")

#: The steps that each output is made of.
OUTPUTS = {"display": ("display",), "linear": ("linear",), "steps": tuple(COMPONENTS)}

LARGEST_SIDE = 65536
MOST_SAMPLES = 64

#: Pixels of a band of an image that is written while it is rendered.
BAND = 1 << 22


class Rendering:
    """A scene and all choices made for its image, checked; rendered as a whole or in bands.

    Takes what `render` takes and raises what it raises. `engine` replaces the backend's own.
    """

    def __init__(
        self,
        scene: Scene | str | Path = DEFAULT_SCENE,
        size: tuple[int, int] = (1920, 1080),
        *,
        backend: str = "jax",
        dtype: str = "float32",
        samples: int = 1,
        output: str = "display",
        intersection: str | None = None,
        shadow_start: str = "offset",
        antialias: str = "none",
        exact_inputs: bool = False,
        skip: bool = True,
        shader: str | Path | None = None,
        uniforms: Mapping[str, Any] | None = None,
        time_limit: float = ForeignShader.time_limit,
        engine: Engine | None = None,
    ):
        _check(size, backend, dtype, samples, output, intersection)
        _choice("shadow_start", shadow_start, SHADOW_STARTS)
        _check_antialias(antialias, backend, output)
        foreign = None
        if shader is not None:
            _check_shader(backend, samples, output, time_limit)
            foreign = ForeignShader(read_shader(shader), tuple((uniforms or {}).items()), float(time_limit))
        elif uniforms:
            raise InputError("uniforms: are those of a shader, and none is given")
        if not isinstance(scene, Scene):
            scene = load_scene(scene)  # which checks it
        elif is_traced(scene):
            if backend != "jax":
                raise InputError(f"backend {backend}: the scene is traced by JAX, which only backend 'jax' can render")
            check_structure(scene)
        else:
            check_scene(scene)
            scene = concrete(scene)
        if intersection is None:
            usual = "robust" if dtype == "float32" else "textbook"
            intersection = BACKENDS[backend].intersection or usual
        self.scene, self.backend, self.dtype, self.output = scene, backend, dtype, output
        self.intersection, self.shadow_start, self.exact_inputs = intersection, shadow_start, exact_inputs
        self.antialias = antialias
        self.frame = Frame(*map(int, size), samples=int(samples))
        program = program_of(scene, intersection, shadow_start, antialias)
        job = Job(program, self.frame, OUTPUTS[output], dtype, exact_inputs, skip, engine, foreign)
        self.renderer = renderer(backend, uniforms_of(scene, self.frame.width / self.frame.height), job)

    def whole(self) -> Any:
        """The image, or the dict of steps."""
        return self._result(self.renderer.draw(0, self.frame.height))

    @property
    def band_height(self) -> int:
        """Rows of each band but the last."""
        return min(self.frame.height, max(1, BAND // (self.frame.width * self.frame.samples**2)))

    def compile(self) -> None:
        """Prepares for `bands`, so that the time that they take is the time of rendering."""
        self.renderer.compile(self.band_height)

    def bands(self) -> Iterator[Any]:
        """The image from the top down, in bands of rows, as NumPy arrays."""
        for first in range(0, self.frame.height, self.band_height):
            images = self.renderer.draw(first, self.band_height)
            rows = min(self.band_height, self.frame.height - first)
            yield self._result({name: np.asarray(image)[:rows] for name, image in images.items()})

    def pixel(self, x: int, y: int) -> Any:
        """The output at one pixel; steps as a dict of numbers and vectors.

        Raises:
            InputError: there is no such pixel.
        """
        width, height, _ = self.frame
        if not (0 <= x < width and 0 <= y < height):
            raise InputError(f"pixel {x} {y}: must be within 0 0 and {width - 1} {height - 1}")
        images = {name: np.asarray(image)[0, x] for name, image in self.renderer.draw(y, 1).items()}
        return self._result(images)

    def metadata(self) -> dict[str, str]:
        """What an image file should say of its origin."""
        linear = self.output == "linear"
        values = "linear light" if linear else f"display values, transfer function {self.scene.film.transfer}"
        return {
            "scene": scene_toml(self.scene),
            "scene_sha256": scene_hash(self.scene),
            "color_space": f"Rec. 709 primaries, {values}",
            "output": self.output,
            "backend": self.backend,
            "dtype": self.dtype,
            "intersection": self.intersection,
            "shadow_start": self.shadow_start,
            "antialias": self.antialias,
            "samples": str(self.frame.samples),
            "exact_inputs": str(self.exact_inputs).lower(),
            "version": version("raytrace"),
            **self.renderer.about(),
        }

    def _result(self, images: dict[str, Any]) -> Any:
        return images if self.output == "steps" else images[self.output]


def render(
    scene: Scene | str | Path = DEFAULT_SCENE,
    size: tuple[int, int] = (1920, 1080),
    *,
    backend: str = "jax",
    dtype: str = "float32",
    samples: int = 1,
    output: str = "display",
    intersection: str | None = None,
    shadow_start: str = "offset",
    antialias: str = "none",
    exact_inputs: bool = False,
    skip: bool = True,
    shader: str | Path | None = None,
    uniforms: Mapping[str, Any] | None = None,
    time_limit: float = ForeignShader.time_limit,
) -> Any:
    """The image of a scene, of shape (height, width, 3), row 0 at the top.

    scene: a `Scene`, concrete or traced by JAX; a built-in's name; or a scene file's path.
    size: (width, height) in pixels.
    backend: "jax"; "numpy"; or the assignment's GLSL on a graphics engine, "opengl" or "webgl".
    dtype: "float32"; with JAX and NumPy "float64"; with NumPy also "longdouble".
    samples: n for the mean, in linear light, of an n x n grid of samples a pixel, at (k + 1/2) / n.
    output: "display" for values in [0, 1]; "linear" for what the film is given, HDR; "steps" for a dict of every
        step of the shader by the assignment's name (`raytrace.shader.Steps`), arrays (height, width) or
        (height, width, components).
    intersection: "textbook", the assignment's formula, or "robust"; by default robust in float32 only,
        and textbook in GLSL.
    shadow_start: "offset", the assignment's 1e-3 along the normal; or, with JAX and NumPy, "surface": shadow rays start
        on the surface, which is left out of what blocks them. So shadows do not depend on the scene's unit of length.
    antialias: "edges" for the mean over each pixel's square: silhouettes, edges of shadows, of patterns and of horizons
        are exact where they are straight, and the image has the derivatives of edges that move. With JAX and NumPy;
        with `samples` each sample is such a square.
    exact_inputs: carry the scene's numbers in `dtype` as they are, instead of rounding each once to float32, which
        is what a GPU is given.
    skip: with JAX and NumPy, leave out what a part of the image does not need: branches that no pixel takes, spheres
        that no ray of it can meet. The bits are the same without, only later.
    shader: a file with somebody's own fragment shader, for "opengl" and "webgl", to run in the place of ours. The
        scene's uniforms are bound by their names; `output` says what it gives, display or linear values.
    uniforms: what a uniform of that shader stands for where its name does not say it: a key of
        `raytrace.glsl.meanings.MEANINGS`, a number, or numbers.
    time_limit: seconds that the shader may take.

    JAX gives JAX arrays, but NumPy's for float64 while x64 mode is off; all others give NumPy's.

    Raises:
        InputError: an argument or a value of the scene is wrong; float64 is asked of a JAX trace without x64; the
            backend's engine is not installed; the shader does not compile, or one of its uniforms is not bound.
        EngineFailure: a graphics engine crashed; the shader did not end in time.
    """
    return Rendering(
        scene,
        size,
        backend=backend,
        dtype=dtype,
        samples=samples,
        output=output,
        intersection=intersection,
        shadow_start=shadow_start,
        antialias=antialias,
        exact_inputs=exact_inputs,
        skip=skip,
        shader=shader,
        uniforms=uniforms,
        time_limit=time_limit,
    ).whole()


def check_size(size: Any) -> None:
    """Raises an InputError unless `size` is a (width, height) that can be rendered."""
    sides = isinstance(size, tuple | list) and len(size) == 2
    if not sides or not all(_is_whole(side) and 1 <= side <= LARGEST_SIDE for side in size):
        raise InputError(f"size: must be (width, height), each from 1 to {LARGEST_SIDE} pixels, found {size!r}")


def _is_whole(number: Any) -> bool:
    return isinstance(number, int | np.integer) and not isinstance(number, bool)


def _check(size: Any, backend: str, dtype: str, samples: int, output: str, intersection: str | None) -> None:
    check_size(size)
    _choice("backend", backend, BACKENDS)
    _choice(f"dtype of backend {backend}", dtype, BACKENDS[backend].dtypes)
    _choice("output", output, OUTPUTS)
    if intersection is not None:
        _choice("intersection", intersection, INTERSECTIONS)
    if not _is_whole(samples) or not 1 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples: must be a whole number from 1 to {MOST_SAMPLES}, found {samples!r}")
    if samples > 1 and output == "steps":
        raise InputError(f"samples: output 'steps' is of one sample a pixel, found {samples}")


def _check_antialias(antialias: str, backend: str, output: str) -> None:
    _choice("antialias", antialias, ANTIALIAS)
    if antialias == "none":
        return
    if backend not in ("jax", "numpy"):
        raise InputError(f"antialias: backend {backend} has none; jax and numpy have")
    if output == "steps":
        raise InputError("antialias: output 'steps' is of one point of each pixel, which has no edges")


def _check_shader(backend: str, samples: int, output: str, time_limit: float) -> None:
    if not BACKENDS[backend].runs_shaders:
        able = [name for name, known in BACKENDS.items() if known.runs_shaders]
        raise InputError(f"shader: backend {backend} runs no shader; these do: {', '.join(able)}")
    if samples > 1:
        raise InputError(f"samples: a shader is run once a pixel, found {samples}")
    if output == "steps":
        raise InputError("output: a shader gives one image, 'display' or 'linear' values, found 'steps'")
    if not time_limit > 0:
        raise InputError(f"time_limit: must be greater than 0 seconds, found {time_limit}")


def _choice(what: str, found: Any, allowed: Any) -> None:
    if found not in list(allowed):
        raise InputError(f"{what}: unknown {found!r}; {did_you_mean(found, allowed, 'there is')}")
