"""What is rendered: the data, its rules, and its files."""

from raytrace.scene.check import check_scene
from raytrace.scene.data import (
    Checkerboard,
    Film,
    MatrixCamera,
    OrthographicCamera,
    PerspectiveCamera,
    Plain,
    Plane,
    Scene,
    Sky,
    Spheres,
    Sun,
)
from raytrace.scene.pytree import register_with_jax
from raytrace.scene.sun import sun_angles, sun_direction
from raytrace.scene.toml import load_scene, save_scene, scene_hash, scene_toml, scenes

__all__ = [
    "Checkerboard",
    "Film",
    "MatrixCamera",
    "OrthographicCamera",
    "PerspectiveCamera",
    "Plain",
    "Plane",
    "Scene",
    "Sky",
    "Spheres",
    "Sun",
    "check_scene",
    "load_scene",
    "save_scene",
    "scene_hash",
    "scene_toml",
    "scenes",
    "sun_angles",
    "sun_direction",
]

register_with_jax()
