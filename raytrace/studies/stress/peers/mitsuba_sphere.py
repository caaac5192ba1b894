"""Mitsuba 3's sphere, in its variant for LLVM; float32 outside, what is inside is its own."""

import numpy as np

from raytrace.studies.bench.peers.mitsuba_queries import prepared
from raytrace.studies.stress.rays import Rays

__all__ = ["intersect"]


def intersect(rays: Rays) -> np.ndarray:
    """t of each ray, float32, -1 where it misses."""
    mitsuba = prepared()
    import drjit

    center, radius = [float(x) for x in rays.center], float(rays.radius)
    world = mitsuba.load_dict({"type": "scene", "it": {"type": "sphere", "center": center, "radius": radius}})
    n = rays.direction.x.size
    origin = mitsuba.Point3f(*(np.broadcast_to(np.float32(x), n) for x in rays.origin))
    ray = mitsuba.Ray3f(origin, mitsuba.Vector3f(*(np.asarray(x, np.float32) for x in rays.direction)))
    hit = world.ray_intersect_preliminary(ray)
    return np.array(drjit.select(hit.is_valid(), hit.t, -1)).reshape(-1)
