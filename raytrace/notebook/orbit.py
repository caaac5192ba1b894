"""Cameras that go around what they look at."""

from dataclasses import replace
from typing import Any

import numpy as np

from raytrace.scene.data import Camera, MatrixCamera, OrthographicCamera, Scene

__all__ = ["orbited", "pivot_of", "zoomed"]

#: Radians that a camera keeps from looking along its `up`.
POLE = 0.02
#: Where a camera that is given by matrices is taken to look, units ahead.
AHEAD = 4.0


def pivot_of(scene: Scene) -> np.ndarray:
    """The point (3,) about which the camera turns: what it looks at, brought to the nearest sphere's distance.

    A camera's target is often only a direction, far before or behind what is to be seen.
    """
    camera = scene.camera
    if isinstance(camera, MatrixCamera):
        position, ahead = camera.view_to_world[:3, 3], -_unit(camera.view_to_world[:3, 2])
    else:
        position, ahead = camera.position, _unit(camera.target - camera.position)
    away = scene.spheres.center - position
    distance = away @ ahead
    # A sphere that the middle of the picture shows, or nearly.
    aside = np.linalg.norm(away - distance[:, None] * ahead, axis=-1) - scene.spheres.radius
    shown = (distance > 0) & (aside < 0.3 * distance)
    if shown.any():
        return position + distance[shown].min() * ahead
    return position + (AHEAD if isinstance(camera, MatrixCamera) else np.linalg.norm(camera.target - position)) * ahead


def orbited(camera: Camera, pivot: np.ndarray, right: float, down: float) -> Camera:
    """The camera after what it sees was turned about the pivot to the right and down, in radians."""
    given = isinstance(camera, MatrixCamera)
    up = np.array([0.0, 1.0, 0.0]) if given else _unit(camera.up)
    back = _unit(camera.view_to_world[:3, 2] if given else camera.position - camera.target)
    side = np.cross(up, back)
    from_up = np.arctan2(np.linalg.norm(side), up @ back)
    tilt = np.clip(from_up - down, min(POLE, from_up), max(np.pi - POLE, from_up)) - from_up
    turn = _rotation(up, -right) @ _rotation(_unit(side) if np.linalg.norm(side) > 1e-9 else np.eye(3)[0], tilt)
    if given:
        return _with_axes(camera, turn, pivot + turn @ (camera.view_to_world[:3, 3] - pivot))
    return replace(
        camera,
        position=pivot + turn @ (camera.position - pivot),
        target=pivot + turn @ (camera.target - pivot),
    )


def zoomed(camera: Camera, pivot: np.ndarray, factor: float) -> Camera:
    """The camera at `factor` times its distance from the pivot; an orthographic one sees so much more or less."""
    if isinstance(camera, OrthographicCamera):
        return replace(camera, height=camera.height * factor)
    if isinstance(camera, MatrixCamera):
        return _with_axes(camera, np.eye(3), pivot + factor * (camera.view_to_world[:3, 3] - pivot))
    position = pivot + factor * (camera.position - pivot)
    return replace(camera, position=position, target=position + (camera.target - camera.position))


def _with_axes(camera: MatrixCamera, turn: np.ndarray, position: np.ndarray) -> MatrixCamera:
    matrix = camera.view_to_world.copy()
    matrix[:3, :3] = turn @ matrix[:3, :3]
    matrix[:3, 3] = position
    return replace(camera, view_to_world=matrix)


def _unit(v: np.ndarray) -> np.ndarray:
    v = v / np.abs(v).max()
    return v / np.linalg.norm(v)


def _rotation(axis: np.ndarray, angle: Any) -> np.ndarray:
    """The matrix that turns about a unit vector by an angle in radians (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
