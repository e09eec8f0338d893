"""Distances along rays in a 3D world of prisms.

The caller validates finite numbers and unit directions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.simulation.kernels.lidar import VERTEX_SLACK


class Space(NamedTuple):
    """The solids of a world, each a vertical prism with a flat bottom and a planar top.

    ``edges`` (n, 4) are ``(ax, ay, bx, by)`` of all outlines, counter-clockwise, those of solid k from ``first[k]`` to
    ``first[k + 1]``; ``boxes`` (k, 6) are the bounding boxes: minimum x, y, z and maximum x, y, z; ``tops`` (k, 3) are
    a, b, c of the planes z = a + b·x + c·y. The ground is the plane z = 0.
    """

    edges: Float64Array
    first: Int64Array
    boxes: Float64Array
    tops: Float64Array


@jit
def _is_inside(edges: Float64Array, start: int, stop: int, x: float, y: float) -> bool:
    """Return whether (x, y) is inside a closed polygon: its winding number is not 0 (Sunday's crossing rule)."""
    winding = 0
    for k in range(start, stop):
        ax, ay, bx, by = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        if ay <= y < by and side > 0.0:
            winding += 1
        elif by <= y < ay and side < 0.0:
            winding -= 1
    return winding != 0


@jit
def _may_hit(box: Float64Array, origin: Float64Array, direction: Float64Array, nearest: float) -> bool:
    """Return whether a ray enters a box before ``nearest`` metres: the slabs of Kay & Kajiya 1986."""
    enter, leave = 0.0, nearest
    for axis in range(3):
        o, d = origin[axis], direction[axis]
        low, high = box[axis] - 1e-9, box[axis + 3] + 1e-9
        if d == 0.0:
            if o < low or o > high:
                return False
            continue
        t0, t1 = (low - o) / d, (high - o) / d
        enter = max(enter, min(t0, t1))
        leave = min(leave, max(t0, t1))
    return enter <= leave


@jit
def cast_in_space(
    space: Space, origin: Float64Array, directions: Float64Array, range_max: float, out: Float64Array
) -> None:
    """Write the distance along each ray from ``origin`` (3,) in ``directions`` (n, 3) to a surface into ``out`` (n,).

    +inf if there is none within ``range_max`` metres. A ray hits the sides of a prism where its projection crosses an
    edge of the outline, and the bottom and the top in their planes within the outline.
    """
    edges, first, boxes, tops = space
    ox, oy, oz = origin[0], origin[1], origin[2]
    for i in range(directions.shape[0]):
        direction = directions[i]
        dx, dy, dz = direction[0], direction[1], direction[2]
        nearest = -oz / dz if dz < 0.0 and oz >= 0.0 else np.inf
        for k in range(boxes.shape[0]):
            box = boxes[k]
            if not _may_hit(box, origin, direction, min(nearest, range_max)):
                continue
            start, stop = first[k], first[k + 1]
            a, b, c = tops[k, 0], tops[k, 1], tops[k, 2]
            bottom = box[2]
            for e in range(start, stop):
                ax, ay = edges[e, 0] - ox, edges[e, 1] - oy
                ex, ey = edges[e, 2] - edges[e, 0], edges[e, 3] - edges[e, 1]
                d_cross_e = dx * ey - dy * ex
                if abs(d_cross_e) < 1e-12:
                    continue
                t = (ax * ey - ay * ex) / d_cross_e
                if t < 0.0 or t >= nearest:
                    continue
                u = (ax * dy - ay * dx) / d_cross_e
                z = oz + t * dz
                top = a + b * (ox + t * dx) + c * (oy + t * dy)
                if -VERTEX_SLACK <= u <= 1.0 + VERTEX_SLACK and bottom <= z <= top:
                    nearest = t
            rise = dz - b * dx - c * dy
            for plane in range(2):
                if plane == 0:
                    if abs(rise) < 1e-12:
                        continue
                    t = (a + b * ox + c * oy - oz) / rise
                else:
                    if abs(dz) < 1e-12:
                        continue
                    t = (bottom - oz) / dz
                if 0.0 <= t < nearest and _is_inside(edges, start, stop, ox + t * dx, oy + t * dy):
                    nearest = t
        out[i] = nearest if nearest <= range_max else math.inf
