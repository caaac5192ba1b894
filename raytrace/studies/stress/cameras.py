"""Primary rays of cameras that see very little or very much, very near and very far, or by nearly singular matrices."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from raytrace.arithmetic.exact import precision
from raytrace.language.glsl import Mat4, Vec2, Vec4
from raytrace.language.tree import tree_map
from raytrace.scene.data import OrthographicCamera, PerspectiveCamera, Scene
from raytrace.scene.to_uniforms import uniforms_of
from raytrace.shader.camera import orthographic_ray, primary_ray
from raytrace.shader.uniforms import Camera
from raytrace.studies.stress.arithmetics import exactly, of_floats
from raytrace.studies.stress.effort import Effort
from raytrace.studies.stress.measure import INPUT, Measurement, at_one, summary

__all__ = ["CameraStress"]

#: Binary digits: nothing is decided here.
BITS = 600
ASPECT = 16 / 9
PLACED = {"position": np.array([0.3, 0.5, 2.0]), "target": np.array([-0.2, 0.1, -1.0])}


class CameraStress:
    """Errors of directions and origins of rays at random places of the image plane."""

    def __init__(self, effort: Effort):
        self.effort = effort
        self.random = np.random.default_rng((3, effort.seed))
        self.cases = effort.cases // 4
        self.rays = [(a.name, a.dtype, a.of(primary_ray)) for a in of_floats()]
        self.parallel = [(a.name, a.dtype, a.of(orthographic_ray)) for a in of_floats()]

    def narrow_view(self) -> Iterator[Measurement]:
        for degrees in self.effort.decades(-7, 2):
            yield from self._directions("narrow_view", degrees, _perspective(field_of_view=float(degrees)))

    def wide_view(self) -> Iterator[Measurement]:
        """By how many degrees the view is less than half of everything."""
        for degrees in self.effort.decades(-7, 2):
            yield from self._directions("wide_view", degrees, _perspective(field_of_view=180 - float(degrees)))

    def near_far(self) -> Iterator[Measurement]:
        """A perspective camera's directions, and the origins of an orthographic one's rays, on its near plane."""
        for ratio in self.effort.decades(0, 12):
            planes = {"near": 0.1, "far": 0.1 * float(ratio) * (1 + 1e-3)}
            yield from self._directions("near_far", ratio, _perspective(**planes))
            yield from self._origins("near_far", ratio, _matrices(OrthographicCamera(3.0, **PLACED, **planes)))

    def camera_matrix(self) -> Iterator[Measurement]:
        """Matrices of any kind, by the condition number of each, at and around the place that they nearly make 0."""
        for condition in self.effort.decades(0, 10):
            x, y = self.random.uniform(-1, 1, 2)
            matrices = Camera(self._ill_conditioned(condition, [x, y, 1]), self._ill_conditioned(condition))
            near = 10 ** self.random.uniform(-10, 0, self.cases) * self.random.choice([-1, 1], (2, self.cases))
            place = Vec2(*(np.array([[x], [y]], np.longdouble) + near))
            yield from self._directions("camera_matrix", condition, matrices, place)

    def _directions(self, axis: str, x: float, camera: Camera, place: Vec2 | None = None) -> Iterator[Measurement]:
        yield from self._points(axis, x, camera, self.rays, lambda ray: ray[1], primary_ray, "direction", place)

    def _origins(self, axis: str, x: float, camera: Camera) -> Iterator[Measurement]:
        yield from self._points(axis, x, camera, self.parallel, lambda ray: ray[0], orthographic_ray, "origin")

    def _points(
        self,
        axis: str,
        x: float,
        camera: Camera,
        runs: list,
        part: Callable,
        function: Callable,
        what: str,
        place: Vec2 | None = None,
    ) -> Iterator[Measurement]:
        """The errors of a vector in units in the last place at 1, of an origin relative to its length."""
        if place is None:
            place = Vec2(*self.random.uniform(-1, 1, (2, self.cases)).astype(np.longdouble))
        for dtype in (np.float32, np.float64):
            given = tree_map(lambda number, dtype=dtype: np.asarray(number).astype(dtype), (camera, place))
            exact = part(exactly(function, *given, bits=BITS))
            condition = (_direction_condition if what == "direction" else _origin_condition)(*given)
            if what == "direction":
                ideal = part(exactly(function, camera, place, bits=BITS))
                with precision(BITS):
                    moved = at_one(tree_map(lambda c: c.floats(np.longdouble), exact), ideal, dtype)
                yield Measurement(axis, x, f"{INPUT}, {dtype.__name__}", self.cases, None, **summary(moved))
            for name, its_dtype, run in runs:
                if its_dtype is dtype:
                    with precision(BITS):
                        errors = at_one(part(run(*given)), exact, dtype)
                    if what == "origin":
                        length = np.sqrt(sum(c.floats() ** 2 for c in exact))
                        errors = errors / length
                    yield Measurement(
                        axis, x, f"{name} {what}", self.cases, None, **summary(errors.max(axis=0), condition)
                    )

    def _ill_conditioned(self, condition: float, shortest: Any = None) -> Mat4:
        """A matrix of that condition number in its first three rows and columns, whose last row is (0, 0, 0, 1).

        It makes `shortest` shortest, or else a random vector.
        """
        first = self.random.normal(size=3) if shortest is None else np.array(shortest, float)
        right = np.linalg.qr(np.column_stack([first, self.random.normal(size=(3, 2))]))[0].T
        left = np.linalg.qr(self.random.normal(size=(3, 3)))[0]
        matrix = np.eye(4)
        matrix[:3, :3] = left @ np.diag(np.geomspace(1 / condition, 1, 3)) @ right
        return Mat4(*(Vec4(*matrix[:, column]) for column in range(4)))


def _perspective(**numbers: Any) -> Camera:
    return _matrices(PerspectiveCamera(**PLACED, **numbers))


def _matrices(camera: PerspectiveCamera | OrthographicCamera) -> Camera:
    return uniforms_of(Scene(camera=camera), ASPECT).camera


def _rows(matrix: Mat4, size: int = 3) -> np.ndarray:
    """The first rows of a matrix, longdouble."""
    return np.array([[np.longdouble(matrix[column][row]) for column in range(4)] for row in range(size)])


def _direction_condition(camera: Camera, place: Vec2) -> np.ndarray:
    """Sum of the changes of the direction, a unit vector, for relative changes of each number: of matrices and place.

    v = M P p changes by |M| |P| |p| in each component for those of M, of P and of p; a direction by that over the
    length of v. (What only changes the length counts too.)
    """
    turn, view = _rows(camera.view_to_world)[:, :3], _rows(camera.ndc_to_view)
    point = np.stack([*place, *np.ones((2, place.x.size))]).astype(np.longdouble)
    vector, largest = turn @ (view @ point), np.abs(turn) @ (np.abs(view) @ np.abs(point))
    return (3 * _length(largest) / _length(vector)).astype(np.float64)


def _origin_condition(camera: Camera, place: Vec2) -> np.ndarray:
    """The same of an orthographic ray's origin, relative to its length; its place has z = -1."""
    world, view = _rows(camera.view_to_world), _rows(camera.ndc_to_view, 4)
    point = np.stack([*place, -np.ones(place.x.size), np.ones(place.x.size)]).astype(np.longdouble)
    vector, largest = world @ (view @ point), np.abs(world) @ (np.abs(view) @ np.abs(point))
    return (3 * _length(largest) / _length(vector)).astype(np.float64)


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt((vectors**2).sum(axis=0))
