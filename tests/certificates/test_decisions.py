"""No course of decisions is missed: engines are within, and so is all that a plain enumeration of all courses finds."""

import numpy as np
import pytest

import raytrace
from raytrace.arithmetic.intervals import GLSL_HIGHP
from raytrace.certificates import certify, verify
from raytrace.certificates.bounds import MOST_COURSES, TOO_MANY, _Program, image_bounds
from raytrace.language.control import Engine
from raytrace.language.tree import tree_map
from raytrace.scene.check import check_scene
from raytrace.scene.to_uniforms import program_of, uniforms_of
from raytrace.shader.pixel import Frame
from tests.certificates.provoking import SIZE, provoking_scene
from tests.scenes import some

FORMULAS = pytest.mark.parametrize("intersection", ["textbook", "robust"])


@pytest.mark.parametrize(
    ("intersection", "scenes"),
    some([("textbook", 12), ("textbook", 40), ("robust", 6), ("robust", 10)], ("textbook", 12), ("robust", 6)),
)
def test_undecided_hits_are_followed_both_ways(intersection, scenes):
    undecided = 0
    for seed in range(scenes):
        scene = provoking_scene(seed)
        check_scene(scene)
        certificate = certify(scene, SIZE, precision="glsl-highp", intersection=intersection)
        undecided += int((certificate.bounds.courses > 1).sum())
        for dtype in ("float32", "float64"):
            for output in ("display", "linear"):
                image = raytrace.render(
                    scene, SIZE, backend="numpy", dtype=dtype, intersection=intersection, output=output
                )
                found = verify(image, certificate, output)
                assert found.inside, f"seed {seed}, {dtype}, {output}: {found}"
    assert undecided > scenes / 2


def test_a_phantom_that_is_left_out_later_takes_no_answer():
    """Blue is a miss that the first run cannot exclude and later ones leave out. Who numbers decisions in the order in
    which they are met gives its answer to the spheres behind it, and loses red, which float64 and Mesa print."""
    phantom = [0.13212765753269196, -0.6557657718658447, 0.7284520268440247]
    behind = (
        [-0.11824539303779602, -1.3324452638626099, 1.7833205461502075],
        [0.25547996163368225, -1.2385817766189575, 1.4973064661026],
        [0.21230782568454742, -1.5897799730300903, 1.3262245655059814],
    )
    radii = [0.003899277886375785, 0.6874204277992249, 0.35693639516830444, 0.52801114320755]
    red, green, blue = np.eye(3)
    scene = raytrace.Scene(
        spheres=raytrace.Spheres([phantom, *behind], radii, np.stack([blue, red, green, green])),
        camera=raytrace.PerspectiveCamera(
            (0, 0, 0),
            (0.08672164, -0.66816794, 0.73893908),
            (-0.99258383, -0.12137518, 0.00673871),
            field_of_view=179.95068542734393,
        ),
        lighting="off",
        film=raytrace.Film(tone_mapper="none", transfer="none"),
    )
    low, high = (
        end[1, 1] for end in certify(scene, SIZE, precision="glsl-highp", intersection="textbook").bounds.display
    )
    for color in (red, green):
        assert (low <= color).all()
        assert (color <= high).all()


class Script(Engine):
    """One pixel, all spheres, and answers by the order of the questions: the plainest way to follow one course."""

    def __init__(self, answers):
        self.answers, self.asked = list(answers), 0

    def decide(self, condition):
        if condition.decision is None:
            holds, fails = (np.broadcast_to(x, condition.shape) for x in (condition.may_hold, condition.may_fail))
            if (holds & fails).any():
                if self.asked == len(self.answers):
                    self.answers.append(True)
                holds = np.full(condition.shape, self.answers[self.asked])
                self.asked += 1
            condition.decision = holds
        return condition.decision

    def branch(self, condition, then, other, args):
        return (then if self.decide(condition).all() else other)(*args)


def every_course(scene, intersection, pixel, most):
    """Return low and high ends of a pixel's linear and display values over all courses, None for more than `most`."""
    uniforms = tree_map(lambda x: np.asarray(x, np.float32).astype(np.float64), uniforms_of(scene, SIZE[0] / SIZE[1]))
    run = _Program(uniforms, program_of(scene, intersection), Frame(*SIZE), GLSL_HIGHP)
    open_, results = [[]], []
    while open_:
        given = open_.pop()
        engine = Script(given)
        hulls = run(np.array([pixel]), engine, engine.decide)
        results.append(np.stack([*hulls.linear, *hulls.display])[:, 0])
        if len(results) > most:
            return None
        open_ += [[*engine.answers[:i], False] for i in range(len(given), len(engine.answers))]
    low, high = np.min(results, axis=0), np.max(results, axis=0)
    return low[0], high[1], low[2], high[3]


def assert_all_courses_are_followed(seeds, intersection):
    compared = 0
    for seed in seeds:
        scene = provoking_scene(seed)
        uniforms = tree_map(lambda x: np.asarray(x, np.float32).astype(np.float64), uniforms_of(scene, 1.0))
        bounds = image_bounds(uniforms, program_of(scene, intersection), Frame(*SIZE), GLSL_HIGHP)
        for pixel in np.flatnonzero((bounds.courses > 1) & (bounds.reason != TOO_MANY)):
            # Without culling there are more questions, whose answers make no difference.
            expected = every_course(scene, intersection, pixel, 40 * MOST_COURSES)
            if expected is None:
                continue
            ends = (*bounds.linear, *bounds.display)
            for end, other in zip(ends, expected, strict=True):
                np.testing.assert_array_equal(end.reshape(-1, 3)[pixel], other, err_msg=f"seed {seed}, pixel {pixel}")
            compared += 1
    return compared


@FORMULAS
def test_the_bounds_are_the_hull_of_all_courses(intersection):
    assert assert_all_courses_are_followed(range(8), intersection) >= 3


@FORMULAS
@pytest.mark.full
def test_the_bounds_are_the_hull_of_all_courses_in_many_scenes(intersection):
    assert assert_all_courses_are_followed(range(100, 150), intersection) >= 15


def test_bounds_do_not_depend_on_the_pixels_beside(monkeypatch):
    """A tile is one row, and the boxes of rays are others: all bounds stay as they are."""
    from raytrace.certificates import bounds

    scene = raytrace.load_scene("checkerboard")
    one = certify(scene, (48, 27), precision="glsl-highp", intersection="textbook")
    monkeypatch.setattr(bounds, "ROWS", 1)
    other = certify(scene, (48, 27), precision="glsl-highp", intersection="textbook")
    for values in ("display", "linear"):
        for a, b in zip(getattr(one.bounds, values), getattr(other.bounds, values), strict=True):
            np.testing.assert_array_equal(a, b)
