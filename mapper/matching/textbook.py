"""Scan matching in plain NumPy, as printed in the papers: the reference for the compiled methods.

Points are (n, 2) float64 in metres, poses (x, y, θ) ``T_map_base``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.se2 import compose, inverse, transform_points
from mapper.grid import GridGeometry


@dataclass(frozen=True, slots=True)
class PointScan:
    """One scan: ``points`` (n, 2) and ``normals`` (n, 2) by beam, if they exist, in the base frame.

    Beam b points in the direction ``first`` + b · ``step`` from ``sensor`` (2,); with ``wraps`` the first beam follows
    the last.
    """

    points: Float64Array
    is_point: BoolArray
    normals: Float64Array
    has_normal: BoolArray
    first: float
    step: float
    wraps: bool
    sensor: Float64Array


def scan_points(
    ranges: NDArray[np.float32], bearings: Float64Array, mount: Float64Array, range_min: float, range_max: float
) -> tuple[Float64Array, BoolArray]:
    """Return the endpoints (n, 2) of readings ``ranges`` (n,), 0 if there is none, and which exist.

    ``bearings`` (n,) are those in the sensor's frame, radians; ``mount`` (3,) is ``T_base_laser``.
    """
    used = (ranges >= range_min) & (ranges <= range_max)
    r = np.where(used, ranges, 0.0).astype(np.float64)
    directions = mount[2] + bearings
    points = mount[:2] + r[:, np.newaxis] * np.stack([np.cos(directions), np.sin(directions)], axis=-1)
    return np.where(used[:, np.newaxis], points, 0.0), used


def scan_normals(
    scan: PointScan, half_width: int, reach: float, most: int, least_gap: float, max_thickness: float
) -> tuple[Float64Array, BoolArray]:
    """Return the normals (n, 2) of a scan's points, 0 if there is none, and which exist.

    The line through a point and its neighbours is along their first principal component. See
    :func:`mapper.matching.kernels.scan_points.write_normals` for which points are neighbours.
    """
    n_beams = len(scan.points)
    normals, has_normal = np.zeros((n_beams, 2)), np.zeros(n_beams, dtype=np.bool_)
    for k in np.flatnonzero(scan.is_point):
        r = math.sqrt(float(np.sum((scan.points[k] - scan.sensor) ** 2)))
        half = max(half_width, int(min(reach / max(r * scan.step, 1e-9), float(most))))
        half = min(half, (n_beams - 1) // 2)
        beams = np.arange(k - half, k + half + 1)
        between = np.abs(beams - k)
        if scan.wraps:
            beams %= n_beams
        inside = (beams >= 0) & (beams < n_beams)
        beams, between = beams[inside], between[inside]
        off = scan.points[beams] - scan.points[k]
        gap = max(least_gap, 3.0 * r * scan.step)
        near = scan.is_point[beams] & (np.sqrt(np.sum(off**2, axis=1)) < gap * np.maximum(between, 1))
        if np.count_nonzero(near) < 3:
            continue
        n, neighbours = np.count_nonzero(near), off[near]
        m_x, m_y = neighbours.sum(axis=0) / n
        c_xx, c_yy = (neighbours**2).sum(axis=0) / n - [m_x * m_x, m_y * m_y]
        c_xy = (neighbours[:, 0] * neighbours[:, 1]).sum() / n - m_x * m_y
        along = 0.5 * math.atan2(2.0 * c_xy, c_xx - c_yy)
        normal = np.array([-math.sin(along), math.cos(along)])
        across = c_xx * normal[0] * normal[0] + 2.0 * c_xy * normal[0] * normal[1] + c_yy * normal[1] * normal[1]
        if c_xx + c_yy - across > 8.0 * across or across < max_thickness * max_thickness:
            to_point = scan.points[k] - scan.sensor
            normals[k] = -normal if normal[0] * to_point[0] + normal[1] * to_point[1] > 0.0 else normal
            has_normal[k] = True
    return normals, has_normal


def beam_towards(scan: PointScan, point: Float64Array) -> int:
    """Return the beam that points towards a point (2,) in the base frame, −1 outside the field of view."""
    n_beams = len(scan.points)
    to_x, to_y = point - scan.sensor
    turned = (math.atan2(to_y, to_x) - scan.first) % (2.0 * math.pi)
    beam = math.floor(turned / scan.step + 0.5)
    if beam < n_beams:
        return beam
    return 0 if scan.wraps or turned > 2.0 * math.pi - 0.5 * scan.step else -1


def beams_around(scan: PointScan, beam: int, most: int) -> Int64Array:
    """Return the beams up to ``most`` beams away from one, including it."""
    n_beams = len(scan.points)
    around = beam + np.arange(-most, most + 1)
    return np.unique(around % n_beams) if scan.wraps else around[(around >= 0) & (around < n_beams)]


def pairs_by_bearing(
    moving: PointScan, pose: Float64Array, fixed: PointScan, at: Float64Array, gate: float, max_beams: int
) -> tuple[Int64Array, Int64Array, int]:
    """Return the beams (m,) of two scans whose points correspond, and the number of points in the field of view.

    Each point of ``moving`` corresponds to the nearest point with a normal of ``fixed`` among the ``max_beams`` beams
    on either side of its bearing, if it is nearer than ``gate``. If that covers all beams, it is the nearest point, in
    the field of view or not.
    """
    tried = 0
    ours, theirs = [], []
    seen = transform_points(compose(inverse(at), pose), moving.points)
    every = max_beams >= len(fixed.points)
    for k in np.flatnonzero(moving.is_point):
        beam = beam_towards(fixed, seen[k])
        if beam < 0 and not every:
            continue
        tried += 1
        around = np.arange(len(fixed.points)) if every else beams_around(fixed, beam, max_beams)
        around = around[fixed.has_normal[around]]
        squares = np.sum((fixed.points[around] - seen[k]) ** 2, axis=1)
        if len(around) and squares.min() < gate * gate:
            ours.append(int(k))
            theirs.append(int(around[np.argmin(squares)]))
    return np.array(ours, dtype=np.int64), np.array(theirs, dtype=np.int64), tried


def compare_views(
    moving: PointScan, pose: Float64Array, fixed: PointScan, at: Float64Array, gate: float, max_beams: int
) -> tuple[float, float, float, float]:
    """Return how many points of a scan are near points of another, in its free space, and behind its measurements.

    The fourth number is Σ (1 − d² / gate²) over the near points, where d is the distance.
    """
    near, through, behind, total = 0, 0, 0, 0.0
    reach = np.sqrt(np.sum((fixed.points - fixed.sensor) ** 2, axis=1))
    for point in transform_points(compose(inverse(at), pose), moving.points)[moving.is_point]:
        beam = beam_towards(fixed, point)
        if beam < 0:
            continue
        r = math.sqrt(float(np.sum((point - fixed.sensor) ** 2)))
        around = beams_around(fixed, beam, max_beams)
        squares = np.sum((fixed.points[around] - point) ** 2, axis=1)[fixed.is_point[around]]
        beside = beams_around(fixed, beam, min(1, max_beams))
        least = reach[beside][fixed.is_point[beside]].min(initial=math.inf)
        if squares.min(initial=math.inf) < gate * gate:
            near += 1
            total += 1.0 - float(squares.min()) / (gate * gate)
        elif math.isfinite(least):
            through += least > r + gate
            behind += least < r - gate
    return float(near), float(through), float(behind), total


def smallest(residuals: Float64Array, share: float) -> BoolArray:
    """Return which residuals (n,) are among the ``share`` · n smallest, at least one. Source: Chetverikov 2002."""
    if share >= 1.0 or not len(residuals):
        return np.ones(len(residuals), dtype=np.bool_)
    squares = residuals**2
    return np.asarray(squares <= np.sort(squares)[min(max(int(share * len(squares)), 1), len(squares)) - 1])


def weights(kind: str, scale: float, residuals: Float64Array) -> Float64Array:
    """Return the weights (n,) of residuals (n,) of an M-estimator: "squares", "huber" or "cauchy".

    Source: Zhang 1997, Parameter estimation techniques.
    """
    if kind == "cauchy":
        return np.asarray(1.0 / (1.0 + (residuals / scale) ** 2))
    if kind == "huber":
        return np.asarray(np.minimum(1.0, scale / np.maximum(np.abs(residuals), 1e-300)))
    return np.ones_like(residuals)


def point_to_line_residuals(
    points: Float64Array, pose: Float64Array, lines: Float64Array, normals: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return e = nᵀ (R p + t − q) (m,) and its derivative with respect to the pose (m, 3). Source: Censi 2008, equation
    3.

    ``points`` (m, 2) p are the moving scan's in its base frame; ``lines`` (m, 2) q and ``normals`` (m, 2) n are in the
    map frame.
    """
    placed = transform_points(pose, points)
    turned = placed - pose[:2]
    e = np.sum(normals * (placed - lines), axis=1)
    by_turn = normals[:, 1] * turned[:, 0] - normals[:, 0] * turned[:, 1]
    return e, np.column_stack([normals, by_turn])


def point_to_point_residuals(
    points: Float64Array, pose: Float64Array, partners: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return e = R p + t − q (2 m,), x and y of each pair in turn, and its derivative with respect to the pose (2 m,
    3).

    Source: Besl & McKay 1992. ``points`` (m, 2) p are the moving scan's in its base frame, ``partners`` (m, 2) q are in
    the map frame.
    """
    placed = transform_points(pose, points)
    turned = placed - pose[:2]
    jacobian = np.zeros((len(points), 2, 3))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -turned[:, 1], turned[:, 0]
    return (placed - partners).reshape(-1), jacobian.reshape(-1, 3)


def best_rigid_motion(points: Float64Array, partners: Float64Array) -> Float64Array:
    """Return the pose (3,) that minimises Σ |R p + t − q|² for pairs of points (n, 2), in closed form.

    Source: Arun, Huang & Blostein 1987; in the plane the rotation is the angle of Σ p · q and Σ p × q about the means.
    """
    p, q = points - points.mean(axis=0), partners - partners.mean(axis=0)
    theta = math.atan2(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]), np.sum(p * q))
    return np.array([*(partners.mean(axis=0) - transform_points([0.0, 0.0, theta], points.mean(axis=0))), theta])


def normal_equations(
    jacobian: Float64Array, residuals: Float64Array, w: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return H = Σ w JᵀJ and −Σ w Jᵀe of the Gauss–Newton step H dx = −Σ w Jᵀe."""
    return jacobian.T @ (w[:, np.newaxis] * jacobian), -jacobian.T @ (w * residuals)


def score_field(geometry: GridGeometry, points: Float64Array, sigma: float, fine: int, reach: int) -> NDArray[np.uint8]:
    """Return the scores (rows, cols) uint8 of cells near map points (n, 2): 255 · exp(−d² / 2σ²) for the nearest point.

    Points are rounded to the middle of their 1/``fine`` of a cell. A point does not affect cells more than ``reach``
    rows or columns away. Source: Olson 2009, section III.
    """
    scores = np.zeros(geometry.shape, dtype=np.uint8)
    for col, row in geometry.to_lattice(points).reshape(-1, 2):
        at_row, at_col = math.floor(row), math.floor(col)
        if not (0 <= at_row < geometry.rows and 0 <= at_col < geometry.cols):
            continue
        rows = np.arange(max(at_row - reach, 0), min(at_row + reach + 1, geometry.rows))
        cols = np.arange(max(at_col - reach, 0), min(at_col + reach + 1, geometry.cols))
        place_row = (math.floor((row - at_row) * fine) + 0.5) / fine
        place_col = (math.floor((col - at_col) * fine) + 0.5) / fine
        d_row = ((rows - at_row) + 0.5 - place_row) * geometry.resolution
        d_col = ((cols - at_col) + 0.5 - place_col) * geometry.resolution
        square = d_row[:, np.newaxis] ** 2 + d_col[np.newaxis, :] ** 2
        stamp = (255 * np.exp(-square / (2.0 * sigma**2))).astype(np.uint8)
        part = scores[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
        np.maximum(part, stamp, out=part)
    return scores


def greatest_in_squares(scores: NDArray[np.uint8], side: int) -> NDArray[np.uint8]:
    """Return the maximum score in the square of ``side`` cells starting at each cell, clipped to the grid."""
    bordered = np.pad(scores, ((0, side - 1), (0, side - 1)))
    return np.asarray(np.lib.stride_tricks.sliding_window_view(bordered, (side, side)).max(axis=(2, 3)))


def scores_in_window(
    scores: NDArray[np.uint8],
    geometry: GridGeometry,
    points: Float64Array,
    pose: Float64Array,
    turns: Float64Array,
    cells: int,
) -> NDArray[np.int32]:
    """Return the score of each pose in a window (len(turns), 2 · cells + 1, 2 · cells + 1): turn, row, column.

    The score of a pose is the sum of the scores of the cells that contain the points (n, 2), 0 outside the grid. The
    points are rotated first and then moved by whole cells. Source: Olson 2009, section IV.
    """
    volume = np.zeros((len(turns), 2 * cells + 1, 2 * cells + 1), dtype=np.int32)
    bordered = np.pad(scores, 2 * cells)
    for a, turn in enumerate(turns):
        at = geometry.world_to_cell(transform_points([pose[0], pose[1], pose[2] + turn], points))
        for row, col in at[((at >= -cells) & (at < np.array(scores.shape) + cells)).all(axis=1)]:
            # The scores around the cell; the padded grid has 2 · cells more on each side.
            volume[a] += bordered[row + cells : row + 3 * cells + 1, col + cells : col + 3 * cells + 1]
    return volume


def field_residuals(
    scores: NDArray[np.uint8], geometry: GridGeometry, points: Float64Array, pose: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return e = 1 − M(R p + t) (m,) of the points (n, 2) inside, and its derivative with respect to the pose (m, 3).

    M is ``scores`` / 255, bilinear between cell centres; points that are not between four centres are omitted. Source:
    Kohlbrecher et al. 2011, equations 4 to 14.
    """
    values = scores.astype(np.float64)
    placed = transform_points(pose, points)
    at = geometry.to_lattice(placed) - 0.5
    low = np.floor(at)
    inside = ((low >= 0) & (low < [geometry.cols - 1, geometry.rows - 1])).all(axis=1)
    turned, at, low = (placed - pose[:2])[inside], at[inside], low[inside].astype(np.int64)
    f_u, f_v = (at - low).T
    col, row = low.T
    m00, m01, m10, m11 = (values[row + r, col + c] for r in (0, 1) for c in (0, 1))
    value = (1 - f_v) * ((1 - f_u) * m00 + f_u * m01) + f_v * ((1 - f_u) * m10 + f_u * m11)
    by_u = (1 - f_v) * (m01 - m00) + f_v * (m11 - m10)
    by_v = (1 - f_u) * (m10 - m00) + f_u * (m11 - m01)
    by_xy = transform_points([0.0, 0.0, geometry.origin[2]], np.stack([by_u, by_v], axis=-1)) / geometry.resolution
    by_turn = by_xy[:, 1] * turned[:, 0] - by_xy[:, 0] * turned[:, 1]
    return 1.0 - value / 255.0, -np.column_stack([by_xy, by_turn]) / 255.0


def split(points: Float64Array, thickness: float, fewest: int) -> list[tuple[int, int]]:
    """Return the first and last index of each straight part of a run of points (n, 2).

    The run is split at the point farthest from the line through its ends. Source: Nguyen et al. 2007.
    """
    if len(points) < fewest:
        return []
    off, along = points[1:-1] - points[0], points[-1] - points[0]
    length = math.sqrt(along[0] * along[0] + along[1] * along[1])
    if length > 0.0:
        distances = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / length
    else:
        distances = np.sqrt(np.sum(off**2, axis=1))
    if not len(distances) or distances.max() <= thickness:
        return [(0, len(points) - 1)]
    at = int(np.argmax(distances)) + 1
    later = split(points[at:], thickness, fewest)
    return split(points[: at + 1], thickness, fewest) + [(first + at, last + at) for first, last in later]


def runs(scan: PointScan, least_gap: float) -> list[Int64Array]:
    """Return the beams of each run of connected points; see :func:`mapper.matching.kernels.segments.split_scan`."""
    used = np.flatnonzero(scan.is_point)
    apart = np.sqrt(np.sum(np.diff(scan.points[used], axis=0) ** 2, axis=1))
    r = np.sqrt(np.sum((scan.points[used] - scan.sensor) ** 2, axis=1))[:-1]
    gaps = np.maximum(least_gap, 3.0 * r * scan.step) * np.diff(used)
    return np.split(used, np.flatnonzero(apart > gaps) + 1) if len(used) else []
