"""Nothing that is skipped changes a bit, forward and in the gradient."""

from dataclasses import replace

import hypothesis
import jax
import numpy as np
import pytest
from hypothesis import strategies as st

import raytrace
from raytrace.backends.jax import Staged, renderer, staged
from raytrace.backends.jax.renderer import Renderer
from raytrace.backends.job import Job
from raytrace.rendering import Options, Rendering
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame
from raytrace.studies.bench.crowds import field
from tests.scenes import SEVERAL_SCENES, examples, filled, some
from tests.strategies import cameras, colors, directions, many, numbers, positions, spheres

SIZE = 96, 54
STEPS = ("t", "index", "shadow", "linear", "display")
#: Small blocks, so that few pixels have many borders.
SMALL = Staged(block=256)


def both(scene, size=SIZE, intersection="robust", dtype="float32", engine=SMALL, keep=STEPS, **choices):
    """The steps with and without skipping."""
    uniforms, program = uniforms_of(scene, size[0] / size[1]), program_of(scene, intersection, **choices)
    job = Job(program, Frame(*size), keep, dtype, engine=engine)
    return tuple(
        {
            name: np.asarray(image)
            for name, image in Renderer(uniforms, replace(job, skip=skip)).draw(0, size[1]).items()
        }
        for skip in (True, False)
    )


def assert_same_bits(skipped, full):
    for name in full:
        np.testing.assert_array_equal(skipped[name], full[name], err_msg=name)


@SEVERAL_SCENES
def test_every_scene(name):
    scene = raytrace.load_scene(name)
    if len(scene.spheres.radius) and scene.lighting != "off":
        scene = filled(scene)
    # Shadows as the step 'shadow' asks for them at every pixel, and as the picture needs them.
    assert_same_bits(*both(scene))
    if len(scene.spheres.radius) and scene.lighting == "shadow":
        assert_same_bits(*both(scene, keep=("linear", "index")))


TEXTBOOK = [(name, dtype) for name in ("checkerboard", "huge-sphere-as-ground") for dtype in ("float32", "float64")]


@pytest.mark.parametrize(("name", "dtype"), some(TEXTBOOK, ("huge-sphere-as-ground", "float64")))
def test_the_textbooks_formula(name, dtype):
    assert_same_bits(*both(filled(raytrace.load_scene(name)), dtype=dtype, intersection="textbook"))


@pytest.mark.parametrize(
    "name", some(["checkerboard", "shadow-of-a-plane", "two-hundred-spheres"], "shadow-of-a-plane")
)
def test_shadow_rays_that_start_on_the_surface(name):
    assert_same_bits(*both(raytrace.load_scene(name), shadow_start="surface"))


@pytest.mark.parametrize("name", some(["ground", "sphere", "many spheres"], "ground"))
def test_edges(name):
    """What a pixel may see of a sphere, or of the ground, beside it is not skipped either."""
    if name == "ground":
        plain = raytrace.Plane(pattern=raytrace.Plain([0.5, 0.5, 0.5]))
        scene = raytrace.Scene(planes=(plain,), lighting="off")
    elif name == "many spheres":
        plain = raytrace.Plane(pattern=raytrace.Plain([0.5, 0.5, 0.5]))
        scene = replace(raytrace.load_scene("checkerboard"), spheres=many(40), planes=(plain,))
    else:
        scene = raytrace.load_scene(name)
    assert_same_bits(*both(scene, keep=("linear",), antialias="edges"))


#: Structures of scenes, for each of which there is one program: the lighting, whether the camera is orthographic, the
#: formula, the start of shadow rays, and which of two planes cast shadows. The first two are those of `filled`.
STRUCTURES = [
    ("shadow", False, "robust", "offset", (False, False)),
    ("shadow", False, "textbook", "offset", (False, False)),
    ("shadow", True, "robust", "surface", (False, True)),
    ("on", False, "robust", "offset", (True, False)),
]


@pytest.mark.parametrize("structure", some([(each,) for each in STRUCTURES], (STRUCTURES[0],)), ids=str)
@examples(3, 12)
@hypothesis.given(data=st.data())
def test_random_scenes(structure, data):
    lighting, orthographic, intersection, shadow_start, casting = structure
    board = raytrace.Checkerboard(data.draw(numbers(0.125, 4)))
    scene = raytrace.Scene(
        spheres=data.draw(spheres(8, 8)),
        planes=[raytrace.Plane(data.draw(positions), data.draw(directions), board, casts) for casts in casting],
        sun=raytrace.Sun(data.draw(directions), data.draw(colors)),
        lighting=lighting,
        camera=data.draw(cameras(orthographic)),
    )
    assert_same_bits(*both(scene, intersection=intersection, shadow_start=shadow_start))


@pytest.mark.parametrize(
    ("n", "intersection"),
    some(
        [
            (40, "robust"),
            (staged.MANY_FOR_SHADOW + 50, "robust"),
            (staged.MANY_FOR_PRIMARY + 100, "robust"),
            (staged.MANY_FOR_PRIMARY + 100, "textbook"),
        ],
        (40, "robust"),
    ),
)
def test_many_spheres(n, intersection):
    """Lists, then cells for shadows, then cells for both; and all of these are NumPy's picture."""
    scene = replace(raytrace.load_scene("checkerboard"), spheres=many(n))
    skipped, full = both(scene, (64, 36), intersection)
    assert_same_bits(skipped, full)
    if intersection == "robust":
        image = raytrace.render(
            scene, (64, 36), backend="numpy", dtype="float32", intersection="robust", output="steps"
        )
        assert np.mean(image["index"] == skipped["index"]) > 0.995
        assert np.mean(image["shadow"] == skipped["shadow"]) > 0.995


@pytest.mark.parametrize(
    "sizes",
    some(
        ["all large", "large and small", "far and wide", "around the camera", "parallel rays"],
        "large and small",
    ),
)
def test_cells_hold_any_mixture(sizes, monkeypatch):
    """Spheres too large for any cell, of every size together, and a few that stretch the grid."""
    monkeypatch.setattr(staged, "MANY_FOR_SHADOW", 20)
    monkeypatch.setattr(staged, "MANY_FOR_PRIMARY", 20)
    monkeypatch.setitem(renderer.FEW, Staged, 20)
    random, n = np.random.default_rng(1), 60
    radius = {
        "all large": random.uniform(0.5, 3, n),
        "large and small": 10 ** random.uniform(-3, 1, n),
        "parallel rays": 10 ** random.uniform(-3, 1, n),
        "far and wide": random.uniform(0.05, 0.2, n),
        "around the camera": 10 ** random.uniform(-1.5, 0, n),
    }[sizes]
    center = random.uniform([-3, -0.4, -6], [3, 2, 1], (n, 3))
    if sizes == "far and wide":
        center[::10] *= 1e5
    if sizes == "around the camera":
        # Some of them are cut by the plane through the camera that no ray lies in.
        center = random.uniform([-20, -0.4, -18], [20, 1.5, 22], (n, 3))
    spheres = raytrace.Spheres(center=center, radius=radius, color=random.uniform(0, 1, (n, 3)))
    scene = replace(raytrace.load_scene("checkerboard"), spheres=spheres)
    if sizes == "parallel rays":
        scene = replace(scene, camera=raytrace.OrthographicCamera(height=4.0))
    # Another block size: the limits are not part of what a program is known by.
    assert_same_bits(*both(scene, engine=Staged(block=300)))


@pytest.mark.full
def test_a_wide_field_leaves_few_spheres_to_every_pixel():
    """Near ones are a thousand times as large as most; half are behind the camera, and some beside it."""
    scene = field(2100)
    uniforms, program = uniforms_of(scene, 16 / 9), program_of(scene, "robust")
    uniforms = jax.tree.map(lambda leaf: jax.numpy.asarray(leaf, "float32"), uniforms)
    assert staged.culling(uniforms, program).primary.grid.large < 40


@pytest.mark.parametrize("intersection", some(["robust", "textbook"], "robust"))
@examples(5, 20)
@hypothesis.given(
    column=st.integers(0, 95),
    row=st.integers(0, 53),
    distance=st.floats(0.5, 1e4),
    radius=st.floats(1e-3, 1),
    data=st.data(),
)
def test_spheres_that_touch_a_ray(column, row, distance, radius, data, intersection):
    """A sphere that a pixel's ray just touches, at a block's border or not: rounding decides, skipping does not."""
    scene = raytrace.load_scene("checkerboard")
    rd = np.asarray(
        Rendering(Options("checkerboard", SIZE, backend="numpy", dtype="float64", output="steps")).pixel(column, row)[
            "rd"
        ]
    )
    across = np.cross(rd, [0.3, 1, 0.2])
    across /= np.linalg.norm(across)
    # Off the ray by the radius, and by a few units in the last place more or less.
    off = radius * (1 + data.draw(st.integers(-8, 8)) * 2.0**-23)
    center = np.asarray(scene.camera.position) + distance * rd + off * across
    spheres = raytrace.Spheres(center=[center, center], radius=[radius, radius], color=np.ones((2, 3)))
    assert_same_bits(*both(filled(replace(scene, spheres=spheres)), intersection=intersection))


@pytest.mark.parametrize("n", some([2, 300], 2))
def test_gradients(n):
    scene = replace(raytrace.load_scene("checkerboard"), spheres=many(n))
    job = Job(program_of(scene, "robust"), Frame(48, 27), ("linear",), "float32")

    def brightness(uniforms, skip):
        return Renderer(uniforms, replace(job, skip=skip)).draw(0, 27)["linear"].mean()

    uniforms = jax.tree.map(np.float32, uniforms_of(scene, 48 / 27))
    with_and_without = [jax.grad(brightness)(uniforms, skip) for skip in (True, False)]
    jax.tree.map(np.testing.assert_array_equal, *with_and_without)


@pytest.mark.full
def test_of_coincident_spheres_the_last_wins_in_cells_too():
    scene = raytrace.load_scene("checkerboard")
    # Twice as many are those of `test_many_spheres`, whose program it is.
    n = (staged.MANY_FOR_PRIMARY + 100) // 2
    crowd = many(n)
    twice = raytrace.Spheres(
        *(np.concatenate([part, part[::-1]]) for part in (crowd.center, crowd.radius, crowd.color))
    )
    index = both(replace(scene, spheres=twice), (64, 36))[0]["index"]
    seen = (index >= 0) & (index < 2 * n)
    assert seen.any()
    assert (index[seen] >= n).all()


def test_numpy_skips_no_bit_either():
    for name in ("checkerboard", "skybox"):
        images = [raytrace.render(name, SIZE, backend="numpy", skip=skip) for skip in (True, False)]
        np.testing.assert_array_equal(*images)


# What the scene does not have is not in the program.


def primitives(scene, size=(32, 18)):
    """How often each primitive occurs in the program for a scene, those within loops and branches included."""
    uniforms, program = uniforms_of(scene, size[0] / size[1]), program_of(scene, "robust")
    renderer = Renderer(uniforms, Job(program, Frame(*size), ("display",), "float32"))
    counts = {}

    def count(jaxpr):
        for equation in jaxpr.eqns:
            counts[equation.primitive.name] = counts.get(equation.primitive.name, 0) + 1
            for value in jax.tree.leaves(list(equation.params.values()), is_leaf=lambda v: hasattr(v, "eqns")):
                inner = getattr(value, "jaxpr", value)
                if hasattr(inner, "eqns"):
                    count(inner)

    from raytrace.backends.jax.draw import Given, draw

    layout, numbers, culled = renderer.prepared()

    def program_text(numbers, mode, first):
        given = Given(numbers, culled)
        return draw(renderer.job, renderer.engine, size[1], renderer.devices, layout, given, mode, first)

    count(jax.make_jaxpr(program_text)(numbers, np.int32(0), np.int32(0)).jaxpr)
    return counts


def test_what_the_scene_lacks_is_not_in_the_program():
    full = raytrace.load_scene("checkerboard")
    everything = primitives(full)
    no_planes = primitives(replace(full, planes=()))
    no_spheres = primitives(replace(full, spheres=raytrace.Spheres()))
    empty = primitives(replace(full, planes=(), spheres=raytrace.Spheres()))
    # One floor for the checkerboard, in two coordinates, another for its parity.
    assert everything["floor"] == 3
    assert "floor" not in no_planes
    # One loop for primary rays, one for shadow rays.
    assert everything["while"] == 2
    assert "while" not in no_spheres
    assert primitives(replace(full, lighting="on"))["while"] == 1
    assert primitives(replace(full, lighting="off"))["sqrt"] < primitives(replace(full, lighting="on"))["sqrt"]
    assert empty["cond"] < no_spheres["cond"] < everything["cond"]
