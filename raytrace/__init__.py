"""raytrace: the vectorized reference implementation of a real-time graphics course's ray tracer."""

from raytrace.certify import Certificate, Verification, certify, read_certificate, verify
from raytrace.compare import Comparison, compare
from raytrace.errors import EngineFailure, InputError
from raytrace.image import read_image, write_image
from raytrace.inverse.fit import SunFit, fit_sun
from raytrace.notebook import view
from raytrace.rendering import render
from raytrace.scene import (
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
    check_scene,
    load_scene,
    save_scene,
    scenes,
    sun_angles,
    sun_direction,
)

__all__ = [
    "Certificate",
    "Checkerboard",
    "Comparison",
    "EngineFailure",
    "Film",
    "InputError",
    "MatrixCamera",
    "OrthographicCamera",
    "PerspectiveCamera",
    "Plain",
    "Plane",
    "Scene",
    "Sky",
    "Spheres",
    "Sun",
    "SunFit",
    "Verification",
    "certify",
    "check_scene",
    "compare",
    "fit_sun",
    "load_scene",
    "read_certificate",
    "read_image",
    "render",
    "save_scene",
    "scenes",
    "sun_angles",
    "sun_direction",
    "verify",
    "view",
    "write_image",
]
