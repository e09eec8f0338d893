"""Ranges of a lidar's beams in a world of line segments, as :mod:`mapper.simulation.kernels.raycast` defines them."""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array
from mapper.core.jit import jit
from mapper.simulation.kernels.raycast import _crossing

TURN = 2.0 * math.pi
VERTEX_SLACK = 1e-9  # of an edge's length: a beam through a vertex shared by two edges must not pass between them
BEAM_SLACK = 1e-6  # of a beam's width: rounding of a bearing must not drop a beam that just grazes a vertex
BEARING_ERROR = 2e-5  # radians: above the error of :func:`_bearing` and of a difference of two bearings
TOUCH = 1e-6  # metres: closer than this the sensor is on the edge
BLOCK = 16  # beams whose directions are rotated from that of the first


@jit
def _bearing(y: float, x: float) -> float:
    """Return atan2(y, x) with an error of at most 1e-5 rad: Abramowitz & Stegun, 4.4.49."""
    across, along = abs(y), abs(x)
    greatest = max(across, along)
    q = min(across, along) / greatest if greatest > 0.0 else 0.0
    s = q * q
    angle = q * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))))
    angle = 0.5 * math.pi - angle if across > along else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@jit
def _write_directions(first_bearing: float, angle_increment: float, out: Float64Array) -> None:
    """Write the cosine and sine of the bearing of each beam into ``out`` (n_beams, 2)."""
    turns = np.empty((BLOCK, 2))
    for i in range(BLOCK):
        turns[i, 0], turns[i, 1] = math.cos(i * angle_increment), math.sin(i * angle_increment)
    n_beams = out.shape[0]
    for first in range(0, n_beams, BLOCK):
        bearing = first_bearing + first * angle_increment
        cos, sin = math.cos(bearing), math.sin(bearing)
        for i in range(min(BLOCK, n_beams - first)):
            out[first + i, 0] = cos * turns[i, 0] - sin * turns[i, 1]
            out[first + i, 1] = sin * turns[i, 0] + cos * turns[i, 1]


@jit
def _is_outside(segments: Float64Array, x: float, y: float) -> bool:
    """Return whether (x, y) is outside all solids, and not on an edge."""
    winding = 0
    touches = False
    for k in range(segments.shape[0]):
        ax, ay, bx, by = segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3]
        winding += _crossing(ax, ay, bx, by, x, y)
        side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        on_line = abs(side) <= TOUCH * (abs(bx - ax) + abs(by - ay))
        beside = (min(ax, bx) - TOUCH <= x <= max(ax, bx) + TOUCH) & (min(ay, by) - TOUCH <= y <= max(ay, by) + TOUCH)
        touches |= on_line & beside
    return winding == 0 and not touches


@jit
def _cross_edge(
    ax: float, ay: float, bx: float, by: float, directions: Float64Array, first: int, last: int, range_max: float,
    out: Float64Array,
) -> None:  # fmt: skip
    """Shorten the beams ``first`` … ``last`` in ``out`` to their crossings with the edge from (ax, ay) to (bx, by).

    The crossing is that of two parametric lines, a + u·e = t·d (O'Rourke, Computational Geometry in C, section 7.2).
    """
    ex, ey = bx - ax, by - ay
    a_cross_b = ax * by - ay * bx
    for i in range(first, last + 1):
        dx, dy = directions[i, 0], directions[i, 1]
        d_cross_e = dx * ey - dy * ex
        if abs(d_cross_e) < 1e-12:
            continue  # parallel to the beam: the neighbouring edges end it
        t = a_cross_b / d_cross_e  # a × e = a × b
        if t >= 0.0 and t < out[i] and t <= range_max:
            u = (ax * dy - ay * dx) / d_cross_e
            if -VERTEX_SLACK <= u <= 1.0 + VERTEX_SLACK:
                out[i] = t


@jit
def cast_rays(
    segments: Float64Array,
    x: float,
    y: float,
    yaw: float,
    angle_min: float,
    angle_increment: float,
    range_max: float,
    out: Float64Array,
) -> None:
    """Write the distance of each beam from (x, y) to the nearest edge into ``out`` (n_beams,), +inf beyond
    ``range_max``.

    Beam i points at ``yaw + angle_min + i · angle_increment``; the fan spans at most one turn. Each edge is tested only
    against the beams between the bearings of its two ends, so the cost is edges + crossings, not edges × beams. From
    outside all solids a beam ends on an edge that it hits from the right, its outside, so other edges are skipped.
    Approximate bearings are sufficient, except for an edge with a beam close to one of its ends.
    """
    n_beams = out.shape[0]
    first_bearing = yaw + angle_min
    directions = np.empty((n_beams, 2))
    _write_directions(first_bearing, angle_increment, directions)
    out[:] = np.inf
    is_outside = _is_outside(segments, x, y)
    beams_of_turn = TURN / angle_increment
    close = BEARING_ERROR / angle_increment + BEAM_SLACK
    bx = by = end_bearing = np.nan
    for k in range(segments.shape[0]):
        ax, ay = segments[k, 0] - x, segments[k, 1] - y
        bearing = end_bearing if ax == bx and ay == by else _bearing(ay, ax)
        bx, by = segments[k, 2] - x, segments[k, 3] - y
        end_bearing = _bearing(by, bx)
        is_left = ax * by - ay * bx >= 0.0  # the sensor is on the inside of the edge
        low, high = (bearing, end_bearing) if is_left else (end_bearing, bearing)
        low = (low - first_bearing) / TURN
        low = (low - math.floor(low)) * beams_of_turn
        width = (high - (bearing if is_left else end_bearing)) / TURN
        width = (width - math.floor(width)) * beams_of_turn
        high = low + width
        is_clear = (
            close < low < beams_of_turn - close
            and close < width < 0.5 * beams_of_turn - close
            and abs(low - np.rint(low)) > close
            and abs(high - np.rint(high)) > close
            and abs(high - beams_of_turn - np.rint(high - beams_of_turn)) > close
        )
        if is_clear:
            if is_left and is_outside:
                continue
            i0, i1 = math.ceil(low), min(n_beams - 1, math.floor(high))
            _cross_edge(ax, ay, bx, by, directions, i0, i1, range_max, out)
            _cross_edge(ax, ay, bx, by, directions, 0, min(n_beams - 1, math.floor(high - beams_of_turn)), range_max,
                        out)  # fmt: skip
            continue
        # The bearings covered by the edge: from its first end, counter-clockwise by `width` (at most half a turn).
        sweep = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        start = (math.atan2(ay, ax) if sweep >= 0.0 else math.atan2(by, bx)) - first_bearing
        start -= math.floor(start / TURN) * TURN
        for lap in range(2):
            from_start = start - lap * TURN
            i0 = max(0, math.ceil(from_start / angle_increment - BEAM_SLACK))
            i1 = min(n_beams - 1, math.floor((from_start + abs(sweep)) / angle_increment + BEAM_SLACK))
            _cross_edge(ax, ay, bx, by, directions, i0, i1, range_max, out)


@jit
def add_noise(
    ranges: Float64Array, noise: Float64Array, sigma: float, range_min: float, range_max: float, out: Float32Array
) -> None:
    """Write the readings of ``ranges`` (n,), metres, with ``sigma`` metres times ``noise`` (n,) into ``out`` (n,).

    No reading is below ``range_min``; readings beyond ``range_max``, compared in float32, are +inf.
    """
    farthest = np.float32(range_max)
    for i in range(out.shape[0]):
        reading = np.float32(max(ranges[i] + sigma * noise[i], range_min))
        out[i] = np.float32(np.inf) if reading > farthest else reading
