"""From a scene to an image: `render`, its `Options`, and `Rendering` for images that are written band by band."""

import inspect
import logging
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cache, lru_cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, ParamSpec, TypeVar, get_type_hints

import numpy as np

from raytrace.backends import BACKENDS, renderer
from raytrace.backends.job import ForeignShader, Job
from raytrace.backends.sharding import explicit_sharding_refused
from raytrace.errors import InputError, check_choice, unknown
from raytrace.glsl.source import read_shader
from raytrace.language.control import Engine
from raytrace.scene.check import check_structure, is_traced
from raytrace.scene.data import Scene, concrete
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.scene.toml import DEFAULT_SCENE, as_scene, scene_hash, scene_toml
from raytrace.shader.main import COMPONENTS
from raytrace.shader.pixel import Frame
from raytrace.shader.shadows import SHADOW_STARTS
from raytrace.shader.sphere import INTERSECTIONS

__all__ = ["Options", "Prepared", "Rendering", "check_size", "prepare", "render"]

LOG = logging.getLogger("raytrace")

#: Means over a pixel: of samples, or of what is on either side of its edges.
ANTIALIAS = ("none", "edges")

#: JAX's own (`raytrace.backends.jax.choice`).
ENGINES = ("staged", "fused", "kernel")

#: The steps that each output is made of.
OUTPUTS = {"display": ("display",), "linear": ("linear",), "steps": tuple(COMPONENTS)}

LARGEST_SIDE = 65536
MOST_SAMPLES = 64
#: Seconds that a shader may be given: a day.
LONGEST_TIME = 86400

#: Pixels of a band of an image that is written while it is rendered.
BAND = 1 << 22


@dataclass(frozen=True)
class Options:
    """A scene and the choices made for its image: the arguments of `render`, which says what each is.

    The texts are what the command says of them.
    """

    scene: Scene | str | Path = DEFAULT_SCENE
    size: Annotated[tuple[int, int], "WIDTHxHEIGHT in pixels."] = (1920, 1080)
    _: KW_ONLY
    backend: Annotated[str, "jax, numpy, opengl or webgl."] = "jax"
    dtype: Annotated[str, "float32; jax, numpy: float64; numpy: longdouble."] = "float32"
    samples: Annotated[int, "n for n x n samples a pixel."] = 1
    output: Annotated[str, "display, linear or steps."] = "display"
    intersection: Annotated[str | None, "textbook or robust; default: robust in float32 only."] = None
    shadow_start: Annotated[
        str, "offset, the assignment's 1e-3 along the normal; jax, numpy: surface, which has no scale."
    ] = "offset"
    antialias: Annotated[
        str, "none, or edges: each pixel the mean over its square, along its edges too; jax, numpy."
    ] = "none"
    exact_inputs: Annotated[bool, "Do not round the scene's numbers to float32."] = False
    skip: Annotated[bool, "Leave out what a part of the image does not need."] = True
    shader: Annotated[
        str | Path | None, "Your own fragment shader, to run instead; with --backend opengl or webgl."
    ] = None
    uniforms: Annotated[
        Mapping[str, Any] | None, "What a uniform of that shader stands for, name=camera_position; repeatable."
    ] = None
    time_limit: Annotated[float, "Seconds that your own shader may take."] = ForeignShader.time_limit
    engine: Engine | str | None = None

    def __post_init__(self):
        object.__setattr__(self, "dtype", _name_of_type(self.dtype))

    def check(self) -> None:
        """Check all but the scene.

        Raises:
            InputError: a choice is wrong, or does not go with another.
        """
        check_size(self.size)
        check_choice("backend", self.backend, BACKENDS)
        check_choice(f"dtype of backend {self.backend}", self.dtype, BACKENDS[self.backend].dtypes)
        if self.output not in OUTPUTS:
            steps = "steps: every step of the shader, such as the normal N and the depth t, in one .exr"
            raise InputError(f"output: {unknown(self.output, OUTPUTS)} ({steps})")
        if self.intersection is not None:
            check_choice("intersection", self.intersection, INTERSECTIONS)
        if not _is_whole(self.samples) or not 1 <= self.samples <= MOST_SAMPLES:
            raise InputError(f"samples: must be a whole number from 1 to {MOST_SAMPLES}, found {self.samples!r}")
        if self.samples > 1 and self.output == "steps":
            raise InputError(f"samples: output 'steps' is of one sample a pixel, found {self.samples}")
        check_choice("shadow_start", self.shadow_start, SHADOW_STARTS)
        check_choice("antialias", self.antialias, ANTIALIAS)
        if self.antialias != "none" and self.backend not in ("jax", "numpy"):
            raise InputError(f"antialias: backend {self.backend} has none; jax and numpy have")
        if self.antialias != "none" and self.output == "steps":
            raise InputError("antialias: output 'steps' is of one point of each pixel, which has no edges")
        if isinstance(self.engine, str):
            check_choice("engine", self.engine, ENGINES)
            if self.backend != "jax":
                raise InputError(f"engine: backend {self.backend} has none by name; jax has: {', '.join(ENGINES)}")
        if self.shader is not None:
            self._check_shader()
        elif self.uniforms:
            raise InputError("uniforms: are those of a shader, and none is given")

    def _check_shader(self) -> None:
        if not BACKENDS[self.backend].runs_shaders:
            able = [name for name, known in BACKENDS.items() if known.runs_shaders]
            raise InputError(f"shader: backend {self.backend} runs no shader; these do: {', '.join(able)}")
        if self.samples > 1:
            raise InputError(f"samples: a shader is run once a pixel, found {self.samples}")
        if self.output == "steps":
            raise InputError("output: a shader gives one image, 'display' or 'linear' values, found 'steps'")
        if not 0 < self.time_limit <= LONGEST_TIME:
            raise InputError(
                f"time_limit: must be greater than 0 and at most {LONGEST_TIME} seconds, found {self.time_limit}"
            )

    def foreign_shader(self) -> ForeignShader | None:
        """Return the user's own shader, read.

        Raises:
            InputError: its file cannot be read, or is no shader.
        """
        if self.shader is None:
            return None
        return ForeignShader(read_shader(self.shader), tuple((self.uniforms or {}).items()), float(self.time_limit))

    def checked_scene(self) -> Scene:
        """Return the scene with arrays of NumPy's; one that JAX traces as it is.

        Raises:
            InputError: there is no such scene, one of its values is wrong, or the backend cannot render a traced one.
        """
        scene = self.scene
        if not isinstance(scene, Scene) or not is_traced(scene):
            return concrete(as_scene(scene))
        if self.backend != "jax":
            raise InputError(f"backend {self.backend}: the scene is traced by JAX, which only backend 'jax' can render")
        check_structure(scene)
        if self.antialias == "none" and (len(scene.planes) or np.size(scene.spheres.radius)):
            _hint_at_edges()
        return scene

    def formula(self) -> str:
        """Return the formula for the sphere."""
        usual = "robust" if self.dtype == "float32" else "textbook"
        return self.intersection or BACKENDS[self.backend].intersection or usual


@cache
def _hint_at_edges() -> None:
    """Log, once, what a traced image's derivative lacks."""
    LOG.warning(
        "the derivative of this image sees colours change, but no silhouette and no shadow move; "
        "antialias='edges' sees them move",
        extra={"hint": True},
    )


def _name_of_type(dtype: Any) -> Any:
    """The name of a type of NumPy's or JAX's, `np.float32`, `jnp.float32` or `np.dtype("float32")`; others as is."""
    if isinstance(dtype, str) or dtype is None:
        return dtype
    try:
        found = np.dtype(dtype)
    except TypeError:
        return dtype
    return "longdouble" if found == np.longdouble and found != np.float64 else found.name


class Rendering:
    """What `Options` ask for, checked; rendered as a whole or in bands. Raises what `render` raises."""

    def __init__(self, options: Options):
        options.check()
        foreign = options.foreign_shader()
        self.options, self.scene, self.intersection = options, options.checked_scene(), options.formula()
        width, height = map(int, options.size)
        self.frame = Frame(width, height, samples=int(options.samples))
        program = program_of(self.scene, self.intersection, options.shadow_start, options.antialias)
        job = Job(
            program,
            self.frame,
            OUTPUTS[options.output],
            options.dtype,
            options.exact_inputs,
            options.skip,
            options.engine,
            foreign,
        )
        self.renderer = renderer(options.backend, uniforms_of(self.scene, width / height), job)

    def whole(self) -> Any:
        """Return the image, or the dict of steps."""
        return self._result(self.renderer.draw(0, self.frame.height))

    @property
    def band_height(self) -> int:
        """The rows of each band but the last."""
        return min(self.frame.height, max(1, BAND // (self.frame.width * self.frame.samples**2)))

    def compile(self) -> None:
        """Prepare for `bands`, so that the time that they take is the time of rendering."""
        self.renderer.compile(self.band_height)

    def bands(self) -> Iterator[Any]:
        """Yield the image from the top down, in bands of rows, as NumPy arrays."""
        height = self.band_height
        following = None
        for first in range(0, self.frame.height, height):
            images = following or self.renderer.draw(first, height)
            last = first + height >= self.frame.height
            # JAX gives an array before it is drawn: so the next band is drawn while the caller encodes this one.
            waits = any(isinstance(image, np.ndarray) for image in images.values())
            following = None if last or waits else self.renderer.draw(first + height, height)
            rows = min(height, self.frame.height - first)
            yield self._result({name: np.asarray(image)[:rows] for name, image in images.items()})

    def pixel(self, x: int, y: int) -> Any:
        """Return the output at one pixel; steps as a dict of numbers and vectors.

        Raises:
            InputError: there is no such pixel.
        """
        width, height, _ = self.frame
        if not (0 <= x < width and 0 <= y < height):
            raise InputError(f"pixel {x} {y}: must be within 0 0 and {width - 1} {height - 1}")
        images = {name: np.asarray(image)[0, x] for name, image in self.renderer.draw(y, 1).items()}
        return self._result(images)

    def metadata(self) -> dict[str, str]:
        """Return what an image file should say of its origin."""
        linear = self.options.output == "linear"
        values = "linear light" if linear else f"display values, transfer function {self.scene.film.transfer}"
        return {
            "scene": scene_toml(self.scene),
            "scene_sha256": scene_hash(self.scene),
            "color_space": f"Rec. 709 primaries, {values}",
            "output": self.options.output,
            "backend": self.options.backend,
            "dtype": self.options.dtype,
            "intersection": self.intersection,
            "shadow_start": self.options.shadow_start,
            "antialias": self.options.antialias,
            "samples": str(self.frame.samples),
            "exact_inputs": str(self.options.exact_inputs).lower(),
            "version": version("raytrace"),
            **self.renderer.about(),
        }

    def _result(self, images: dict[str, Any]) -> Any:
        return images if self.options.output == "steps" else images[self.options.output]


P = ParamSpec("P")
Result = TypeVar("Result")


def taking(options: Callable[P, Options]) -> Callable[[Callable[[Options], Result]], Callable[P, Result]]:
    """Decorate a function of `Options` so that it takes their fields as arguments of its own."""
    signature, hints = inspect.signature(options), get_type_hints(options)
    plain = [parameter.replace(annotation=hints[name]) for name, parameter in signature.parameters.items()]

    def decorated(function: Callable[[Options], Result]) -> Callable[P, Result]:
        @wraps(function)
        def with_arguments(*args: P.args, **choices: P.kwargs) -> Result:
            signature.bind(*args, **choices)  # else an unknown argument would be said to be one of `Options`
            return function(options(*args, **choices))

        with_arguments.__signature__ = signature.replace(parameters=plain, return_annotation=Any)  # pyright: ignore[reportAttributeAccessIssue]
        return with_arguments

    return decorated


@taking(Options)
def render(options: Options) -> Any:
    """Render a scene to an image of shape (height, width, 3), row 0 at the top.

    scene: a `Scene`, concrete or traced by JAX; a built-in's name; or a scene file's path.
    size: (width, height) in pixels.
    backend: "jax"; "numpy"; or the assignment's GLSL on a graphics engine, "opengl" or "webgl".
    dtype: "float32"; with JAX and NumPy "float64"; with NumPy also "longdouble". Or such a type of NumPy's or JAX's.
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
    shader: a file with a user's own fragment shader, for "opengl" and "webgl", to run in the place of ours. The
        scene's uniforms are bound by their names; `output` says what it gives, display or linear values.
    uniforms: what a uniform of that shader stands for where its name does not say it: a key of
        `raytrace.glsl.meanings.MEANINGS`, a number, or numbers.
    time_limit: seconds that the shader may take.
    engine: how the shader's control words are run, instead of the backend's own way: an engine
        (`raytrace.language.Engine`), or with JAX the name of one of its own. "staged" draws tiles, as suits a CPU;
        "kernel" is one kernel of a GPU, whose tiles XLA draws, slowly, where there is no GPU; "fused" leaves all to
        XLA, but with more than 32 spheres, or edges, it is "staged" with one tile. Edges, a user's tone mapper and
        derivatives have no kernel, and get "fused". By default the platform decides on which the image is drawn.

    JAX gives JAX arrays, but NumPy's for float64 while x64 mode is off; all others give NumPy's.

    Raises:
        InputError: an argument or a value of the scene is wrong; float64 is asked of a JAX trace without x64; the
            backend's engine is not installed; the shader does not compile, or one of its uniforms is not bound.
        EngineFailure: a graphics engine crashed; the shader did not end in time.
    """
    return _drawn(options)


def _drawn(options: Options) -> Any:
    with explicit_sharding_refused():
        return _rendering(options).whole()


class Prepared:
    """A scene and options whose program is compiled; see `prepare`."""

    def __init__(self, options: Options):
        scene = options.scene
        self.options = options if isinstance(scene, Scene) else replace(options, scene=as_scene(scene))
        self._rendering = _rendering(self.options)
        self._rendering.renderer.compile(self._rendering.frame.height)

    def __call__(self, scene: Scene | None = None) -> Any:
        """Render the scene, or the one that was prepared.

        Nothing compiles for a scene of the same structure: as many spheres and planes, the same choices, exposure and
        white balance where those of the first were. The scene may be traced, as in a step of an optimizer under
        `jax.jit`. Raises what `render` raises.
        """
        return self._rendering.whole() if scene is None else _drawn(replace(self.options, scene=scene))


@taking(Options)
def prepare(options: Options) -> Prepared:
    """Compile the program of a scene now, for a loop that renders it, or others of its structure, many times.

    Arguments and errors are those of `render`. ``renderer = raytrace.prepare(scene, (640, 360))``, then
    ``renderer(scene)``.
    """
    return Prepared(options)


#: Pictures that are kept ready: a loop over a few scenes or sizes finds each of them again.
KEPT = 8
#: A scene of more bytes than this is not kept: what is prepared of its spheres may be hundreds of times that.
LARGEST_KEPT = 1 << 16


def _rendering(options: Options) -> Rendering:
    """Return the kept `Rendering` of an equal scene and equal options, or make one.

    For JAX alone, and concrete scenes. What an array holds decides, as an array may be changed in place.
    """
    if options.backend != "jax" or not isinstance(options.scene, Scene):
        return Rendering(options)
    import jax.core

    # Before what is equal is looked for: a wrong choice can be equal to a right one, as True is to 1.
    options.check()
    leaves, tree = jax.tree.flatten(options.scene)
    if any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
        return Rendering(options)
    arrays = [np.asarray(leaf) for leaf in leaves]
    if sum(array.nbytes for array in arrays) > LARGEST_KEPT:
        return Rendering(options)
    numbers = tuple((array.shape, array.dtype, array.tobytes()) for array in arrays)
    config: Any = jax.config  # whose attributes JAX makes at run time
    # A forked process has another number: there JAX does not work, which a new renderer says.
    switches = config.jax_default_device, config.jax_enable_x64, os.getpid()
    choices = tuple(value for name, value in vars(options).items() if name != "scene")
    try:
        return _kept(_Same((tree, numbers, switches, choices), options))
    except TypeError:  # a choice that has no hash: one that is wrong, or a user's own
        return Rendering(options)


@dataclass(frozen=True)
class _Same:
    """Options, which are equal if their keys are."""

    key: tuple
    options: Options = field(compare=False)


@lru_cache(maxsize=KEPT)
def _kept(same: _Same) -> Rendering:
    return Rendering(same.options)


def check_size(size: Any) -> None:
    """Check a (width, height) in pixels.

    Raises:
        InputError: it cannot be rendered.
    """
    sides = isinstance(size, tuple | list) and len(size) == 2
    if not sides or not all(_is_whole(side) and 1 <= side <= LARGEST_SIDE for side in size):
        raise InputError(f"size: must be (width, height), each from 1 to {LARGEST_SIDE} pixels, found {size!r}")


def _is_whole(number: Any) -> bool:
    return isinstance(number, int | np.integer) and not isinstance(number, bool)
