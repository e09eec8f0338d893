"""Distances in a world of line segments: from points, and along short motions.

``segments`` is always (n, 4) float64, ``(ax, ay, bx, by)`` in metres, the edges of closed counter-clockwise polygons,
which may overlap. The caller validates that numbers are finite.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit

RUN = 64  # maximum number of consecutive points that share a search for their nearest edges
RUN_RADIUS = 0.5  # metres: their maximum distance from the centre of their bounding box
CULL_SLACK = 1e-6  # metres: rounding must not drop an edge that is exactly as near as another


@jit
def _squared_distance(ax: float, ay: float, ex: float, ey: float, x: float, y: float) -> float:
    """Return the squared distance of (x, y) from the edge that starts at (ax, ay) and runs along (ex, ey)."""
    px, py = x - ax, y - ay
    length2 = ex * ex + ey * ey
    u = 0.0 if length2 == 0.0 else min(1.0, max(0.0, (px * ex + py * ey) / length2))
    qx, qy = px - u * ex, py - u * ey
    return qx * qx + qy * qy


@jit
def _crossing(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> int:
    """Return the contribution of an edge to the winding number of (x, y): 1, -1 or 0 (Sunday's crossing rule)."""
    side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    if ay <= y < by and side > 0.0:
        return 1
    if by <= y < ay and side < 0.0:
        return -1
    return 0


@jit
def nearest_edge(segments: Float64Array, x: float, y: float, out: Float64Array) -> float:
    """Return the clearance of (x, y), and write the nearest point of any edge into ``out`` (2,).

    The clearance is the distance to the nearest edge in metres, negative inside a solid, where the winding number is
    not 0 because every polygon is counter-clockwise (Sunday's crossing rule). Inside overlapping solids only the sign
    is meaningful. Without edges it is +inf and ``out`` is unchanged.
    """
    best = np.inf
    winding = 0
    for k in range(segments.shape[0]):
        ax, ay = segments[k, 0], segments[k, 1]
        bx, by = segments[k, 2], segments[k, 3]
        ex, ey = bx - ax, by - ay
        px, py = x - ax, y - ay
        length2 = ex * ex + ey * ey
        u = 0.0 if length2 == 0.0 else min(1.0, max(0.0, (px * ex + py * ey) / length2))
        qx, qy = px - u * ex, py - u * ey
        d2 = qx * qx + qy * qy
        if d2 < best:
            best = d2
            out[0] = ax + u * ex
            out[1] = ay + u * ey
        winding += _crossing(ax, ay, bx, by, x, y)
    return -math.sqrt(best) if winding != 0 else math.sqrt(best)


@jit
def clearances(segments: Float64Array, points: Float64Array, out: Float64Array) -> None:
    """Write the clearance of each of ``points`` (n, 2) into ``out`` (n,), bit for bit that of :func:`nearest_edge`.

    Consecutive points that are close together share a search: only edges that may be nearest to one of them, or are
    needed for one of their crossing counts, are tested for each.
    """
    n_points, n_edges = min(points.shape[0], out.shape[0]), segments.shape[0]
    away = np.empty(n_edges)
    near = np.empty(n_edges, dtype=np.int64)
    crossing = np.empty(n_edges, dtype=np.int64)
    first = 0
    while first < n_points:
        x_low = x_high = points[first, 0]
        y_low = y_high = points[first, 1]
        stop = first + 1
        while stop < min(first + RUN, n_points):
            left, right = min(x_low, points[stop, 0]), max(x_high, points[stop, 0])
            lower, upper = min(y_low, points[stop, 1]), max(y_high, points[stop, 1])
            if not math.hypot(right - left, upper - lower) <= 2.0 * RUN_RADIUS:
                break
            x_low, x_high, y_low, y_high = left, right, lower, upper
            stop += 1
        x, y = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high)
        half = math.hypot(x_high - x, y_high - y)
        n_crossing = 0
        least = np.inf
        for k in range(n_edges):
            ax, ay = segments[k, 0], segments[k, 1]
            bx, by = segments[k, 2], segments[k, 3]
            away[k] = math.sqrt(_squared_distance(ax, ay, bx - ax, by - ay, x, y))
            least = min(least, away[k])
            # A ray to the right of a point crosses only edges at its height that end to the right of it.
            if not (max(ay, by) <= y_low or min(ay, by) > y_high or max(ax, bx) < x_low - CULL_SLACK):
                crossing[n_crossing] = k
                n_crossing += 1
        # Distances differ by at most `half` between the centre and any of the points (triangle inequality).
        reach = least + 2.0 * half + CULL_SLACK
        n_near = 0
        for k in range(n_edges):
            if not away[k] > reach:  # written such that NaN keeps every edge
                near[n_near] = k
                n_near += 1
        for i in range(first, stop):
            x, y = points[i, 0], points[i, 1]
            best = np.inf
            for j in range(n_near):
                k = near[j]
                ax, ay = segments[k, 0], segments[k, 1]
                distance = _squared_distance(ax, ay, segments[k, 2] - ax, segments[k, 3] - ay, x, y)
                best = min(best, distance)
            winding = 0
            for j in range(n_crossing):
                k = crossing[j]
                winding += _crossing(segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3], x, y)
            out[i] = -math.sqrt(best) if winding != 0 else math.sqrt(best)
        first = stop


@jit
def arc_clearance(
    segments: Float64Array,
    x: float,
    y: float,
    theta: float,
    linear: float,
    angular: float,
    duration: float,
    n_samples: int,
) -> float:
    """Return the minimum clearance at ``n_samples`` points of a unicycle's motion from (x, y, theta).

    ``linear`` m/s and ``angular`` rad/s held for ``duration`` seconds; the exact arc of Probabilistic Robotics, section
    5.3.3.
    """
    nearest = np.zeros(2)
    least = nearest_edge(segments, x, y, nearest)
    for i in range(1, n_samples + 1):
        t = duration * i / n_samples
        half = 0.5 * angular * t
        # The chord of an arc: length v·t·sin(h)/h in the direction theta + h, with h half the turn.
        chord = linear * t * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        px, py = x + chord * math.cos(theta + half), y + chord * math.sin(theta + half)
        least = min(least, nearest_edge(segments, px, py, nearest))
    return least


@jit
def chord_clearance(segments: Float64Array, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the minimum distance in metres between the straight line from (x0, y0) to (x1, y1) and any edge.

    0 if it crosses one. The nearest points of two segments that do not cross include an end of one of them.
    """
    dx, dy = x1 - x0, y1 - y0
    d2 = dx * dx + dy * dy
    nearest = np.zeros(2)
    least = min(abs(nearest_edge(segments, x0, y0, nearest)), abs(nearest_edge(segments, x1, y1, nearest)))
    for k in range(segments.shape[0]):
        ax, ay = segments[k, 0] - x0, segments[k, 1] - y0
        bx, by = segments[k, 2] - x0, segments[k, 3] - y0
        side_a, side_b = dx * ay - dy * ax, dx * by - dy * bx
        ex, ey = bx - ax, by - ay
        side_0, side_1 = ey * ax - ex * ay, ey * (ax - dx) - ex * (ay - dy)
        if side_a * side_b < 0.0 and side_0 * side_1 < 0.0:
            return 0.0
        if d2 == 0.0:
            continue
        u = min(1.0, max(0.0, (ax * dx + ay * dy) / d2))  # every vertex starts one edge, so ends need no separate test
        least = min(least, math.hypot(ax - u * dx, ay - u * dy))
    return least


@jit
def farthest_in_sight(segments: Float64Array, x: float, y: float, path: Float64Array, ahead: int, room: float) -> int:
    """Return the last of the points 1 … ``ahead`` of ``path`` (n, 2) with a straight clearance of ``room`` from (x, y).

    That is, the :func:`chord_clearance` of the straight line to it is at least ``room`` metres; 0 if there is none.
    """
    for i in range(ahead, 0, -1):
        if chord_clearance(segments, x, y, path[i, 0], path[i, 1]) >= room:
            return i
    return 0
