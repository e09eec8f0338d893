"""Costmaps step by step in plain NumPy, as in Nav2: the reference for the compiled functions.

Sources: nav2_costmap_2d: inflation_layer.cpp, obstacle_layer.cpp, static_layer.cpp, costmap_2d.hpp (raytraceLine),
costmap_layer.cpp (updateWithMax and related functions), voxel_layer.cpp; denoise_layer.cpp; nav2_voxel_grid:
voxel_grid.hpp.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array, Int64Array, UInt8Array
from mapper.costmap.costs import FREE, INSCRIBED, LETHAL, NO_INFORMATION, cost_of_distance
from mapper.grid.occupancy_grid import GridGeometry


def interpret_value(
    value: int,
    track_unknown_space: bool,
    lethal_cost_threshold: int,
    trinary_costmap: bool,
    unknown_cost_value: int,
    inscribed_obstacle_cost_value: int,
) -> int:
    """Return the cost of one value of a map, 0 … 100 or 255 for unknown (StaticLayer::interpretValue)."""
    if value == unknown_cost_value:
        return NO_INFORMATION if track_unknown_space else FREE
    if value == inscribed_obstacle_cost_value:
        return INSCRIBED
    if value >= lethal_cost_threshold:
        return LETHAL
    if trinary_costmap:
        return FREE
    return int(value / lethal_cost_threshold * LETHAL)


def squared_distances(obstacles: BoolArray, radius: int) -> Int64Array:
    """Return the squared distance (rows, cols), in cells, of each cell to the nearest obstacle, by brute force.

    ``obstacles`` (rows, cols) is a mask. Distances beyond ``radius`` cells are radius² + 1.
    """
    rows, cols = np.indices(obstacles.shape)
    best = np.full(obstacles.shape, radius * radius + 1, dtype=np.int64)
    for row, col in np.argwhere(obstacles):
        best = np.minimum(best, (rows - row) ** 2 + (cols - col) ** 2)
    return best


def inflate(
    costs: UInt8Array,
    resolution: float,
    cell_radius: int,
    inscribed_radius: float,
    cost_scaling_factor: float,
    inflate_unknown: bool,
    inflate_around_unknown: bool,
) -> UInt8Array:
    """Return the costs (rows, cols) after inflation (InflationLayer::updateCosts)."""
    obstacles = costs == LETHAL
    if inflate_around_unknown:
        obstacles |= costs == NO_INFORMATION
    squared = squared_distances(obstacles, cell_radius)
    out = costs.copy()
    for row, col in np.ndindex(*costs.shape):
        if squared[row, col] > cell_radius * cell_radius:
            continue
        distance = math.sqrt(squared[row, col]) * resolution
        cost = cost_of_distance(distance, inscribed_radius, cost_scaling_factor)
        old = int(costs[row, col])
        if old == NO_INFORMATION and (cost > FREE if inflate_unknown else cost >= INSCRIBED):
            out[row, col] = cost
        else:
            out[row, col] = max(old, cost)
    return out


def line_cells(start_rc: tuple[int, int], end_rc: tuple[int, int], max_cells: int, min_cells: int) -> Int64Array:
    """Return the cells (n, 2), (row, col), cleared between two cells (Costmap2D::raytraceLine).

    Bresenham's line from ``start_rc`` to ``end_rc``, both included, without cells nearer than ``min_cells`` or farther
    than ``max_cells`` from its start.
    """
    d_row, d_col = end_rc[0] - start_rc[0], end_rc[1] - start_rc[1]
    distance = math.hypot(d_row, d_col)
    if distance < min_cells:
        return np.zeros((0, 2), dtype=np.int64)
    share = 1.0 if distance == 0.0 else min(1.0, max_cells / distance)
    first = (0.0, 0.0) if distance == 0.0 else (d_row / distance * min_cells, d_col / distance * min_cells)
    row, col = int(start_rc[0] + first[0]), int(start_rc[1] + first[1])
    step_row, step_col = (1 if d_row > 0 else -1), (1 if d_col > 0 else -1)
    by_col = abs(d_col) >= abs(d_row)
    major, minor = (abs(d_col), abs(d_row)) if by_col else (abs(d_row), abs(d_col))
    error = major // 2
    cells = []
    for _ in range(max(min(int(share * major) - min_cells, major), 0)):
        cells.append((row, col))
        error += minor
        over = error >= major
        error -= major if over else 0
        row += step_row * (over if by_col else 1)
        col += step_col * (1 if by_col else over)
    return np.array([*cells, (row, col)], dtype=np.int64)


def mark_and_clear(
    costs: UInt8Array,
    geometry: GridGeometry,
    sensor: Float64Array,
    points: Float64Array,
    marking: tuple[float, float, float, float] | None,
    clearing: tuple[float, float] | None,
) -> UInt8Array:
    """Return an obstacle layer's costs (rows, cols) after one observation (ObstacleLayer::updateBounds).

    ``points`` (n, 3) and ``sensor`` (3,) are in map metres. ``clearing`` is (raytrace_min_range, raytrace_max_range):
    the cells from the sensor to each point, with the line clipped at the map's border, become free. ``marking`` is
    (obstacle_min_range, obstacle_max_range, min_obstacle_height, max_obstacle_height): then the cells of the points
    within these limits become lethal. Nothing is cleared if the sensor is outside the map.
    """
    out = costs.copy()
    rows, cols = geometry.shape
    if clearing is not None and geometry.contains(geometry.world_to_cell(sensor[:2])):
        least, most = (max(0, math.ceil(bound / geometry.resolution - 1e-9)) for bound in clearing)
        start = geometry.world_to_cell(sensor[:2])
        o_u, o_v = geometry.to_lattice(sensor[:2])
        for point in points:
            u, v = geometry.to_lattice(point[:2])
            share = 1.0
            for begin, end, side in ((o_u, u, cols), (o_v, v, rows)):
                if end < 0.0:
                    share = min(share, -begin / (end - begin))
                elif end >= side:
                    share = min(share, (side - begin) / (end - begin))
            u, v = o_u + share * (u - o_u), o_v + share * (v - o_v)
            end_rc = (min(max(math.floor(v), 0), rows - 1), min(max(math.floor(u), 0), cols - 1))
            cells = line_cells((int(start[0]), int(start[1])), end_rc, most, least)
            out[cells[:, 0], cells[:, 1]] = FREE
    if marking is not None:
        nearest, farthest, lowest, highest = marking
        for point in points:
            squared = float(np.sum((point - sensor) ** 2))
            if not (lowest <= point[2] <= highest and nearest**2 <= squared < farthest**2):
                continue
            row, col = geometry.world_to_cell(point[:2])
            if 0 <= row < rows and 0 <= col < cols:
                out[row, col] = LETHAL
    return out


def combine(master: UInt8Array, layer: UInt8Array, method: str) -> UInt8Array:
    """Return the costs (rows, cols) after combining a layer with them (CostmapLayer::updateWith...).

    ``overwrite`` uses the layer's cost where it has information, ``max`` the greater one, ``max_known`` the greater one
    where the master has information, ``true_overwrite`` always the layer's cost.
    """
    out = master.copy()
    for row, col in np.ndindex(*master.shape):
        old, new = int(master[row, col]), int(layer[row, col])
        takes = {
            "true_overwrite": True,
            "overwrite": new != NO_INFORMATION,
            "max": new != NO_INFORMATION and (old == NO_INFORMATION or old < new),
            "max_known": NO_INFORMATION not in (old, new) and old < new,
        }
        if takes[method]:
            out[row, col] = new
    return out


def _length(vector: Float64Array) -> float:
    return math.sqrt(sum(float(part) * float(part) for part in vector))


def voxel_line(start: Float64Array, end: Float64Array, most: int, least: int) -> Int64Array:
    """Return the voxels (n, 3), (row, col, level), cleared between two points (VoxelGrid::raytraceLine).

    ``start`` and ``end`` are (3,) lattice coordinates (v, u, level); ``least`` and ``most`` are lengths on the lattice.
    The line advances one step at a time along its longest axis, with ties resolved in favour of column, then row.
    """
    length = _length(end - start)
    if int(length) < least:
        return np.zeros((0, 3), dtype=np.int64)
    share = min(1.0, most / length) if length > 0.0 else 1.0
    skipped = least / length if length > 0.0 else 0.0
    at = (start + (end - start) * skipped).astype(np.int64)
    steps = end.astype(np.int64) - at
    signs, steps = np.where(steps > 0, 1, -1), np.abs(steps)
    major = max((1, 0, 2), key=lambda axis: int(steps[axis]))
    errors = np.full(3, steps[major] // 2)
    cells = [at.copy()]
    for _ in range(min(int(share * steps[major]), int(steps[major]))):
        errors += steps
        for axis in range(3):
            if axis == major or errors[axis] >= steps[major]:
                at[axis] += signs[axis]
                errors[axis] -= steps[major]
        cells.append(at.copy())
    return np.array(cells)


VOXEL_FREE, VOXEL_UNKNOWN, VOXEL_MARKED = 0, 1, 2


def mark_voxels(
    voxels: UInt8Array,
    costs: UInt8Array,
    geometry: GridGeometry,
    sensor: Float64Array,
    points: Float64Array,
    marking: tuple[float, float, float, float],
    heights: tuple[float, float],
    mark_threshold: int,
) -> None:
    """Mark the voxels (rows, cols, levels) of points, and make columns with more marks than the threshold lethal.

    ``marking`` is as in :func:`mark_and_clear`, ``heights`` is (origin_z, z_resolution). Points below the columns mark
    the lowest voxel. Source: VoxelLayer::updateBounds.
    """
    rows, cols, levels = voxels.shape
    nearest, farthest, lowest, highest = marking
    for point in points:
        squared = float(np.sum((point - sensor) ** 2))
        if not (lowest <= point[2] <= highest and nearest**2 <= squared < farthest**2):
            continue
        row, col = geometry.world_to_cell(point[:2])
        level = int((max(point[2], heights[0]) - heights[0]) / heights[1])
        if 0 <= row < rows and 0 <= col < cols and level < levels:
            voxels[row, col, level] = VOXEL_MARKED
            if np.sum(voxels[row, col] == VOXEL_MARKED) > mark_threshold:
                costs[row, col] = LETHAL


def clear_voxels(
    voxels: UInt8Array,
    costs: UInt8Array,
    geometry: GridGeometry,
    sensor: Float64Array,
    points: Float64Array,
    clearing: tuple[float, float],
    heights: tuple[float, float],
    thresholds: tuple[int, int],
) -> None:
    """Clear the voxels (rows, cols, levels) between the sensor and points, and set the costs of their columns.

    ``thresholds`` are (mark_threshold, unknown_threshold): a column with at most mark_threshold marked voxels becomes
    free, or unknown if it has more than unknown_threshold unknown voxels. Source: VoxelLayer::raytraceFreespace,
    VoxelGrid::ClearVoxelInMap.
    """
    rows, cols, levels = voxels.shape
    sides = np.array([rows, cols, levels], dtype=np.float64)

    def on_lattice(point: Float64Array) -> Float64Array:
        u, v = geometry.to_lattice(point[:2])
        return np.array([v, u, (point[2] - heights[0]) / heights[1]])

    def inside(place: Float64Array) -> bool:
        return bool((place >= 0.0).all() and (place < sides).all())

    start = on_lattice(sensor)
    if not inside(start):
        return
    least, most = (max(0, math.ceil(bound / geometry.resolution - 1e-9)) for bound in clearing)
    for point in points:
        distance = _length(point - sensor)
        if distance == 0.0:
            continue
        before = max((distance - 2.0 * geometry.resolution) / distance, 0.0)
        end = on_lattice(sensor + before * (point - sensor))
        share = 1.0
        for axis in (2, 1, 0):
            top = sides[axis] - (0.01 / heights[1] if axis == 2 else 0.0)
            if end[axis] > sides[axis]:
                share = min(share, max(0.0, (top - start[axis]) / (end[axis] - start[axis])))
            elif end[axis] < 0.0:
                share = min(share, -start[axis] / (end[axis] - start[axis]))
        if share > 0.0 and ((end > sides) | (end < 0.0)).any():
            share -= 1e-5
        end = start + share * (end - start)
        if not inside(end):
            continue
        for row, col, level in voxel_line(start, end, most, least):
            voxels[row, col, level] = VOXEL_FREE
            column = voxels[row, col]
            if np.sum(column == VOXEL_MARKED) <= thresholds[0]:
                unknown = int(np.sum(column == VOXEL_UNKNOWN))
                costs[row, col] = FREE if unknown <= thresholds[1] else NO_INFORMATION


def denoise(costs: UInt8Array, minimal_group_size: int, connectivity: int, unknown_is_obstacle: bool) -> UInt8Array:
    """Return the costs (rows, cols) without groups of fewer than ``minimal_group_size`` obstacles (DenoiseLayer).

    A group is a connected component of obstacles, over neighbours that share an edge or, with a ``connectivity`` of 8,
    a corner. Lethal and inscribed cells are obstacles, and unknown ones if ``unknown_is_obstacle``.
    """
    rows, cols = costs.shape
    obstacles = {LETHAL, INSCRIBED, *([NO_INFORMATION] if unknown_is_obstacle else [])}
    steps = [(0, 1), (1, 0), (0, -1), (-1, 0)]
    if connectivity == 8:
        steps += [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    out, seen = costs.copy(), np.zeros(costs.shape, dtype=np.bool_)
    for start in np.ndindex(costs.shape):
        if seen[start] or int(costs[start]) not in obstacles:
            continue
        group, open_cells = [], [start]
        seen[start] = True
        while open_cells:
            row, col = open_cells.pop()
            group.append((row, col))
            for d_row, d_col in steps:
                near = (row + d_row, col + d_col)
                inside = 0 <= near[0] < rows and 0 <= near[1] < cols
                if inside and not seen[near] and int(costs[near]) in obstacles:
                    seen[near] = True
                    open_cells.append(near)
        if len(group) < minimal_group_size:
            for cell in group:
                out[cell] = FREE
    return out
