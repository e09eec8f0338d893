"""A ring of sonars: each measures the nearest object in its cone, without the bearing of the echo."""

from __future__ import annotations

import math

import numpy as np

from mapper.simulation.kernels.lidar import cast_rays
from mapper.simulation.worlds import Float64Array, World

RAY_STEP = math.radians(1.0)  #: between the rays that sample a cone


def rays_of_cone(beam_width: float) -> Float64Array:
    """Return the bearings (n_rays,) off a cone's axis, radians, of the rays that sample it.

    At most :data:`RAY_STEP` apart, the cone's edges and its axis among them; ``beam_width`` is from edge to edge.
    """
    n_rays = 2 * math.ceil(beam_width / 2.0 / RAY_STEP) + 1
    return np.linspace(-beam_width / 2.0, beam_width / 2.0, n_rays)


def ranges_in_cones(
    world: World, pose: tuple[float, float, float], bearings: Float64Array, beam_width: float, range_max: float
) -> Float64Array:
    """Return the distance (n, n_rays), metres, along each ray of each cone to the first solid, +inf where none is.

    ``pose`` (x, y, yaw) is ``T_map_sensor``; ``bearings`` (n,) of the cones' axes and ``beam_width`` are radians; the
    rays are those of :func:`rays_of_cone`. A sonar measures the nearest surface that returns an echo. Source: the
    wide beam of a time of flight sonar, Moravec & Elfes 1985.
    """
    x, y, yaw = pose
    rays = rays_of_cone(beam_width)
    out = np.empty((len(bearings), len(rays)))
    for k, bearing in enumerate(bearings.tolist()):
        cast_rays(world.seen, x, y, yaw, bearing + rays[0], rays[1] - rays[0], range_max, out[k])
    return out
