"""A ring of sonars: each hears the nearest thing in its cone, and not in which direction of the cone it is."""

from __future__ import annotations

import math

import numpy as np

from mapper.kernels.raycast import cast_rays
from mapper.world.worlds import Float64Array, World

RAY_STEP = math.radians(1.0)  #: between the rays that feel for what lies in a cone


def nearest_in_cones(
    world: World, pose: tuple[float, float, float], bearings: Float64Array, beam_width: float, range_max: float
) -> Float64Array:
    """Return the distance (n,), metres, from ``pose`` to the nearest solid in each cone, +inf where there is none.

    ``pose`` (x, y, yaw) is ``T_map_sensor``; ``bearings`` (n,) and ``beam_width``, from edge to edge, are radians. A
    cone is felt for with rays at most :data:`RAY_STEP` apart, its edges and its axis among them. Source: the wide beam
    of a time of flight sonar, Moravec & Elfes 1985, section 2.
    """
    x, y, yaw = pose
    n_rays = 2 * math.ceil(beam_width / 2.0 / RAY_STEP) + 1
    step = beam_width / (n_rays - 1)
    rays = np.empty(n_rays)
    out = np.empty(len(bearings))
    for k, bearing in enumerate(bearings.tolist()):
        cast_rays(world.segments, x, y, yaw, bearing - beam_width / 2.0, step, range_max, rays)
        out[k] = rays.min()
    return out
