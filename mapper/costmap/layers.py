"""Layers of a costmap: each has its own costs, or modifies those of the layers before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mapper.core.array_types import Float64Array, Int8Array, Int64Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import FREE, INSCRIBED, LETHAL, NO_INFORMATION, cells_of, name_of_cost
from mapper.costmap.footprint import Footprint
from mapper.costmap.inflation import inflate, radius_in_cells
from mapper.costmap.kernels.marking import Marking
from mapper.costmap.kernels.observation import clear_lines, fill_polygon, lay_over, mark_cells
from mapper.costmap.parameters import (
    COMBINATIONS,
    CostmapConfig,
    InflationConfig,
    ObstacleConfig,
    SourceConfig,
    StaticConfig,
)
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry
from mapper.sensors.scan import RangeScan

_OVERWRITE_ALL = 3
_SHORT_OF_RANGE_MAX = 1e-4  #: metres by which Nav2 shortens a beam without return


@dataclass(frozen=True, slots=True)
class Observation:
    """Endpoints of readings: ``points`` (n, 3) and the sensor's position (3,) in map metres; ``stamp`` in seconds.

    ``source`` is the name of the observation source in its layer, None for the first one. Raises :class:`ConfigError`
    for other shapes and for values that are not finite.
    """

    sensor: Float64Array
    points: Float64Array
    stamp: float = 0.0
    source: str | None = None

    def __post_init__(self) -> None:
        sensor, points = np.asarray(self.sensor, dtype=np.float64), np.asarray(self.points, dtype=np.float64)
        if sensor.shape != (3,) or points.ndim != 2 or points.shape[1] != 3:
            raise ConfigError(
                "costmap.observation",
                f"An observation has a sensor (3,) and points (n, 3), not {sensor.shape} and {points.shape}.",
            )
        if not (np.isfinite(sensor).all() and np.isfinite(points).all() and np.isfinite(self.stamp)):
            raise ConfigError("costmap.observation", "The points of an observation must be finite.")
        object.__setattr__(self, "sensor", sensor)
        object.__setattr__(self, "points", np.ascontiguousarray(points))


@dataclass(frozen=True, slots=True)
class Robot:
    """Pose of the robot, (x, y, yaw) in the map, and its padded outline."""

    pose: tuple[float, float, float]
    footprint: Footprint


class Layer(Protocol):
    """A layer of a :class:`mapper.costmap.layered.LayeredCostmap`."""

    @property
    def name(self) -> str:
        """The layer's name in Nav2's plugin lists."""

    @property
    def costs(self) -> UInt8Array:
        """Its costs (rows, cols) uint8."""

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Update the layer; return the box of cells that changed since the last call."""

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Apply the layer to the cells of ``box`` of ``master`` (rows, cols)."""

    def why(self, row: int, col: int) -> str:
        """Return the reason for the layer's cost in a cell: one sentence."""


def part_of(box: CellBox) -> tuple[slice, slice]:
    """Return the rows and columns of a box as an index."""
    return slice(box.row0, box.row1), slice(box.col0, box.col1)


def box_of(bounds: Int64Array) -> CellBox | None:
    """Return the box of the bounds (row0, row1, col0, col1) that a kernel extended, or None if it wrote nothing."""
    row0, row1, col0, col1 = (int(bound) for bound in bounds)
    return CellBox(row0, row1, col0, col1) if row0 < row1 and col0 < col1 else None


def no_bounds() -> Int64Array:
    """Return empty bounds (row0, row1, col0, col1)."""
    most = np.iinfo(np.int64).max
    return np.array([most, 0, most, 0], dtype=np.int64)


class StaticLayer:
    """The map as lethal, free and unknown or, with ``trinary_costmap`` off, with costs in between (StaticLayer)."""

    name = "static_layer"

    def __init__(self, geometry: GridGeometry, values: Int8Array, config: StaticConfig, general: CostmapConfig) -> None:
        if values.shape != geometry.shape:
            raise ConfigError(
                "costmap.shape", f"The map has {values.shape} values, but the costmap {geometry.shape} cells."
            )
        self._geometry, self._values, self._config = geometry, values.copy(), config
        self._under_robot: CellBox | None = None  #: cells of which some are free because the robot is there
        table = static_costs(config, general.track_unknown_space)
        self.costs: UInt8Array = table[values.view(np.uint8)]
        self._table = table
        self._changed: CellBox | None = CellBox(0, geometry.rows, 0, geometry.cols)

    def renew(self, values: Int8Array, box: CellBox) -> None:
        """Update the map's values in the cells of ``box``, as for a map that is still being built.

        Raises :class:`ConfigError` if their shape is not that of the box.
        """
        part = self._values[part_of(box)]
        if values.shape != part.shape:
            message = f"The box has {part.shape} cells, but there are {values.shape} values."
            raise ConfigError("costmap.shape", message)
        differs = values != part
        if not differs.any():
            return
        rows, cols = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
        near = CellBox(
            box.row0 + int(rows[0]), box.row0 + int(rows[-1]) + 1, box.col0 + int(cols[0]), box.col0 + int(cols[-1]) + 1
        )
        self._values[part_of(box)] = values
        self.costs[part_of(box)] = self._table[values.view(np.uint8)]
        self._changed = near if self._changed is None else self._changed | near

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Return the whole map the first time, then the updated boxes.

        With ``footprint_clearing_enabled`` the cells under the robot are free while it is there.
        """
        del now
        box, self._changed = self._changed, None
        if self._config.footprint_clearing_enabled:
            before, bounds = self._under_robot, no_bounds()
            if before is not None:
                self.costs[part_of(before)] = self._table[self._values[part_of(before)].view(np.uint8)]
            if robot is not None:
                clear_footprint(self._geometry, robot, FREE, self.costs, bounds)
            self._under_robot = box_of(bounds)
            for other in (before, self._under_robot):
                box = other if box is None else box if other is None else box | other
        return box

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Write the map into the master, or with ``use_maximum`` keep the greater cost."""
        if self._config.enabled:
            method = COMBINATIONS.index("max") if self._config.use_maximum else _OVERWRITE_ALL
            lay_over(self.costs[part_of(box)], method, master[part_of(box)])

    def why(self, row: int, col: int) -> str:
        """Describe the map value from which the cost was derived."""
        value, cost = int(self._values[row, col]), int(self.costs[row, col])
        value_text = "unknown" if value < 0 else f"{value} of 100"
        return f"The map’s value is {value_text}: {name_of_cost(cost)}."


def static_costs(config: StaticConfig, track_unknown_space: bool) -> UInt8Array:
    """Return the cost (256,) uint8 of each map value; unknown (−1) has index 255.

    Source: nav2_costmap_2d, static_layer.cpp, interpretValue.
    """
    values = np.arange(256)
    threshold = int(config.lethal_cost_threshold)
    between = (values / threshold * LETHAL).astype(np.int64)
    costs = np.where(values >= threshold, LETHAL, FREE if config.trinary_costmap else between)
    costs[int(config.inscribed_obstacle_cost_value)] = INSCRIBED
    costs[int(config.unknown_cost_value)] = NO_INFORMATION if track_unknown_space else FREE
    return costs.astype(np.uint8)


class MarkedLayer:
    """Costs marked and cleared by observations: the common base of the obstacle and the voxel layer."""

    def __init__(self, geometry: GridGeometry, config: ObstacleConfig, general: CostmapConfig) -> None:
        self._geometry, self._config = geometry, config
        first = NO_INFORMATION if general.track_unknown_space else FREE
        self.costs: UInt8Array = np.full(geometry.shape, first, dtype=np.uint8)
        self._bounds = no_bounds()

    @property
    def config(self) -> ObstacleConfig:
        """The current parameters."""
        return self._config

    def configure(self, config: ObstacleConfig) -> None:
        """Replace the parameters; existing marks are kept."""
        self._config = config

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Clear the costs under the robot (but not the voxels, as in Nav2); return the box that changed."""
        del now
        if robot is not None and self._config.footprint_clearing_enabled:
            clear_footprint(self._geometry, robot, FREE, self.costs, self._bounds)
        box, self._bounds = box_of(self._bounds), no_bounds()
        return box

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Combine the obstacles with the master by ``combination_method``."""
        if self._config.enabled:
            lay_over(
                self.costs[part_of(box)], COMBINATIONS.index(self._config.combination_method), master[part_of(box)]
            )


class ObstacleLayer(MarkedLayer):
    """Obstacles marked and cleared by readings (ObstacleLayer)."""

    name = "obstacle_layer"

    def observe(self, *observations: Observation) -> None:
        """Clear the cells along the beams of all observations, then mark their endpoints, by their source's
        parameters.
        """
        seen = seen_by_sources(self._config, observations)
        for source, observation in seen:
            clear(self._geometry, source, observation, FREE, self.costs, self._bounds)
        for source, observation in seen:
            mark(self._geometry, self._config, source, observation, LETHAL, self.costs, self._bounds)

    def why(self, row: int, col: int) -> str:
        """Describe whether a reading marked or cleared the cell."""
        sentences = {
            LETHAL: "A reading ended here, and none passed through since: lethal.",
            FREE: "No obstacle: beams passed through, or nothing was seen here.",
            NO_INFORMATION: "No beam has been here: no information.",
        }
        return sentences[int(self.costs[row, col])]


class InflationLayer:
    """Costs around the obstacles of the layers before (InflationLayer)."""

    name = "inflation_layer"

    def __init__(self, geometry: GridGeometry, config: InflationConfig, inscribed_radius: float) -> None:
        self._geometry, self._config, self._inscribed = geometry, config, inscribed_radius
        self.radius = radius_in_cells(config, geometry.resolution) if config.enabled else 0
        self.costs: UInt8Array = np.zeros(geometry.shape, dtype=np.uint8)
        self._under: UInt8Array = self.costs

    def spread(self, under: UInt8Array, box: CellBox) -> None:
        """Write the costs of the cells of ``box``; ``under`` (rows, cols) are the costs of the layers before."""
        self._under = under
        inflate(under, self._config, self._geometry.resolution, self._inscribed, self.costs, box)

    def why(self, row: int, col: int) -> str:
        """Describe the distance to the nearest obstacle, and the component of the cost that it determines."""
        nearest = self.nearest(row, col)
        if nearest is None:
            return f"No obstacle within {self._config.inflation_radius:g} m: no cost."
        at_row, at_col, distance = nearest
        x, y = self._geometry.cell_to_world((at_row, at_col))
        cost = name_of_cost(int(self.costs[row, col]))
        if distance == 0.0:
            return "The cell is an obstacle itself."
        within = "within" if distance <= self._inscribed else "outside"
        return (
            f"The nearest obstacle is {distance:.2f} m away at ({x:.2f}, {y:.2f}), {within} the inscribed radius of "
            f"{self._inscribed:.2f} m: {cost}."
        )

    def nearest(self, row: int, col: int) -> tuple[int, int, float] | None:
        """Return the nearest obstacle within the radius: its row, column and distance in metres."""
        top, left = max(row - self.radius, 0), max(col - self.radius, 0)
        near = self._under[top : row + self.radius + 1, left : col + self.radius + 1]
        obstacles = near == LETHAL
        if self._config.inflate_around_unknown:
            obstacles |= near == NO_INFORMATION
        cells = np.argwhere(obstacles)
        if len(cells) == 0:
            return None
        squared = ((cells - np.array([row - top, col - left])) ** 2).sum(axis=1)
        best = int(squared.argmin())
        if squared[best] > self.radius**2:
            return None
        at_row, at_col = (int(place) for place in cells[best] + np.array([top, left]))
        return at_row, at_col, float(np.sqrt(squared[best])) * self._geometry.resolution


def seen_by_sources(
    config: ObstacleConfig, observations: Sequence[Observation]
) -> list[tuple[SourceConfig, Observation]]:
    """Return the source parameters of each observation, and its points within that source's heights.

    Source: nav2_costmap_2d, observation_buffer.cpp, bufferCloud.
    """
    seen = []
    for observation in observations:
        source, z = config.source(observation.source), observation.points[:, 2]
        is_inside = (z >= source.min_obstacle_height) & (z <= source.max_obstacle_height)
        seen.append(
            (source, observation if is_inside.all() else replace(observation, points=observation.points[is_inside]))
        )
    return seen


def clear(
    geometry: GridGeometry,
    source: SourceConfig,
    observation: Observation,
    value: float,
    out: np.ndarray,
    bounds: Int64Array,
) -> None:
    """Write ``value`` into the cells along the beams of an observation."""
    if source.clearing:
        least, most = clearing_cells(source, geometry)
        as_stored = out.dtype.type(value)
        clear_lines(observation.points, observation.sensor, geometry.frame, least, most, as_stored, out, bounds)


def clearing_cells(source: SourceConfig, geometry: GridGeometry) -> tuple[int, int]:
    """Return the range of distances from the sensor, in cells, in which a beam clears."""
    least, most = (cells_of(r, geometry.resolution) for r in (source.raytrace_min_range, source.raytrace_max_range))
    return least, most


def mark(
    geometry: GridGeometry,
    config: ObstacleConfig,
    source: SourceConfig,
    observation: Observation,
    value: float,
    out: np.ndarray,
    bounds: Int64Array,
) -> None:
    """Write ``value`` into the cells of the endpoints that mark."""
    if source.marking:
        marking, as_stored = marking_of(config, source), out.dtype.type(value)
        mark_cells(observation.points, observation.sensor, geometry.frame, marking, as_stored, out, bounds)


def marking_of(config: ObstacleConfig, source: SourceConfig) -> Marking:
    """Return the marking limits of a source for the kernels, with the layer's heights."""
    return Marking(
        source.obstacle_min_range, source.obstacle_max_range, config.min_obstacle_height, config.max_obstacle_height
    )


def clear_footprint(geometry: GridGeometry, robot: Robot, value: float, out: np.ndarray, bounds: Int64Array) -> None:
    """Write ``value`` into the cells under the robot."""
    lattice = geometry.to_lattice(robot.footprint.at(robot.pose))
    fill_polygon(lattice, out.dtype.type(value), out, bounds)


def observation_of_scan(
    scan: RangeScan,
    sensor_pose: Sequence[float] | Float64Array,
    *,
    inf_is_valid: bool = False,
    height: float = 0.0,
) -> Observation:
    """Return the endpoints of a scan from a sensor at ``sensor_pose`` (x, y, yaw) in the map, at ``height`` m.

    With ``inf_is_valid`` a beam without return ends at the scan's maximum range, otherwise it is ignored, as are
    invalid readings. Source: nav2_costmap_2d, obstacle_layer.cpp, laserScanValidInfCallback.
    """
    x, y, yaw = (float(v) for v in sensor_pose)
    ranges = scan.ranges.astype(np.float64)
    if inf_is_valid:
        ranges = np.where(np.isposinf(ranges), scan.range_max - _SHORT_OF_RANGE_MAX, ranges)
    valid = (ranges >= scan.range_min) & (ranges <= scan.range_max)
    ranges, angles = ranges[valid], scan.angles[valid] + yaw
    points = np.column_stack([x + ranges * np.cos(angles), y + ranges * np.sin(angles), np.full(len(ranges), height)])
    return Observation(np.array([x, y, height]), points, scan.stamp_ns * 1e-9)
