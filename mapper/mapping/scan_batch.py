"""A batch of scans as the kernels take them, and the two passes that put it into a grid on all cores.

The first pass turns readings into lines or runs of cells and is split by scans; the second adds the evidence and is
split by rows of the grid, so each cell gets its additions from one thread, in the order of the log. The result does not
depend on the number of threads, not in its last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.parallel import bands, cores, in_parallel, shares
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import cell_statistics
from mapper.mapping.cone_update import contributions_in_cones, drawer_of_cones, evidence_of, ramp_increments
from mapper.mapping.kernels.amanatides_woo import RAY_FIELDS, draw_rays, plan_rays
from mapper.mapping.kernels.bresenham import LINE_FIELDS, MAX_STEPS, draw_lines, plan_lines, reach
from mapper.mapping.kernels.contributions import (
    contributions_of_fields,
    contributions_of_lines,
    contributions_of_rays,
    filter_readings_near_cell,
)
from mapper.mapping.kernels.moravec_elfes import add_certainties
from mapper.mapping.kernels.negative_zero import decode_observed, encode_unobserved
from mapper.mapping.kernels.smooth_ramp import draw_ramps
from mapper.mapping.kernels.types import LogOddsUpdate, ReadingFilter
from mapper.mapping.parameters import CONES, MappingConfig
from mapper.mapping.per_scan_update import drawer_of_fields, plan_of_fields

_CHUNK_READINGS = 1 << 19  # planned at once: each turn costs two rounds of the threads
_WORTH_SHARING = 1 << 12  # readings: below this a second thread costs more than it brings
_ENCODE_ABOVE_UPDATES_PER_CELL = 2.0  # updates for each cell of the box: below this it is cheaper to note each one

Scans = tuple[
    NDArray[np.float32], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]
]  # ranges, sensors, beams, fields, headings
Draw = Callable[[int, int, NDArray[np.int64]], int]


@dataclass(frozen=True, slots=True)
class _Plan:
    """What beams will draw: the lines or rays, how many cells in each row, and the box of the grid that holds all."""

    planned: NDArray[Any]
    work: NDArray[np.float64]
    box: NDArray[np.int64]


@dataclass(frozen=True)  # without slots: what is derived once is kept
class ScanBatch:
    """Scans of one sensor, with the poses it had."""

    ranges: NDArray[np.float32]  # (n_scans, n_beams)
    sensor_poses: NDArray[np.float64]  # (n_scans, 3), T_map_laser
    angles: NDArray[np.float64]  # (n_beams,)
    fields: NDArray[np.float64]  # (n_beams, 4), see mapper.sensors.scan.beam_fields
    range_min: float
    range_max: float

    @cached_property
    def sensors(self) -> NDArray[np.float64]:
        """(n_scans, 4): x, y, cos θ, sin θ."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2])
        return np.column_stack([self.sensor_poses[:, :2], np.cos(theta), np.sin(theta)])

    @cached_property
    def beams(self) -> NDArray[np.float64]:
        """(n_beams, 2): cosine and sine of the bearings."""
        return np.column_stack([np.cos(self.angles), np.sin(self.angles)])

    def headings(self, geometry: GridGeometry) -> NDArray[np.float64]:
        """(n_scans, 2): cosine and sine of the sensor's heading along the lattice."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2] - geometry.origin[2])
        return np.column_stack([np.cos(theta), np.sin(theta)])

    def reading_filter(self, config: MappingConfig) -> ReadingFilter:
        """Which readings count and how, as the kernels take it."""
        model = config.beam_model()
        growth = 4.0 * config.sigma_growth if config.model == "smooth_ramp" else 0.0
        return (self.range_min, self.range_max, 2.0 * model.half_window(0.0), growth, config.no_return == "free")

    def scans_on(self, geometry: GridGeometry) -> Scans:
        """The scans as the kernels of fields and cones take them: ranges, sensors, beams, fields, headings."""
        return self.ranges, self.sensors, self.beams, self.fields, self.headings(geometry)

    def bounds(self, config: MappingConfig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The least and greatest x, y (2,) of the sensors and of all that they see."""
        out = np.array([np.inf, np.inf, -np.inf, -np.inf])
        directions = [self.beams]
        if (config.update == "per_scan" or config.model in CONES) and len(self.fields):
            # A field ends in an arc. It lies within the corners of the polygon around it: right, middle and left.
            right, left = self.fields[:, :2], self.fields[:, 2:]
            cos_half = np.minimum(np.sum(right * self.beams, axis=1), np.sum(left * self.beams, axis=1))
            stretch = 1.0 / np.cos(0.5 * np.arccos(np.clip(cos_half, 0.0, 1.0)))[:, np.newaxis]
            directions = [right * stretch, self.beams * stretch, left * stretch]
        for direction in directions:
            reach(self.ranges, self.sensors, np.ascontiguousarray(direction), self.reading_filter(config), out)
        return out[:2], out[2:]

    def add_to(self, grid: OccupancyGrid, config: MappingConfig) -> tuple[int, NDArray[np.int64]]:
        """Add all scans; what falls outside the grid is clipped.

        Return the number of cell updates and the box (row0, row1, col0, col1) of what was touched, half-open; it is
        empty where row1 ≤ row0. Raises :class:`ConfigError` for cells so small that a beam crosses too many of them.
        """
        check_beam_length(self.range_max + config.beam_model().half_window(self.range_max), grid.geometry.resolution)
        threads = cores() if self.ranges.size >= _WORTH_SHARING else 1
        rows, cols = grid.geometry.shape
        box = np.array([rows, 0, cols, 0], dtype=np.int64)
        cell_statistics.begin(grid, config)
        if config.model == "moravec_elfes":
            count = self._add_certainties(grid, config, box)
        elif config.model == "hit_counting":
            count = self._count(grid, config, threads, box)
        else:
            count = self._draw(grid, config, log_odds_update_of(config), threads, box)
        cell_statistics.show(grid, config, box)
        return count, box

    def _draw(
        self,
        grid: OccupancyGrid,
        config: MappingConfig,
        log_odds_update: LogOddsUpdate,
        threads: int,
        box: NDArray[np.int64],
    ) -> int:
        """Add all scans by ``log_odds_update``; return the number of cell updates and widen ``box``."""
        if _is_wide(config):
            evenly = np.ones(grid.geometry.rows)
            return _in_bands(
                drawer_of_cones(self, grid, config, log_odds_update), evenly, (0, len(evenly)), threads, box
            )
        draw_sweep = self._draw_fields if config.update == "per_scan" else self._draw_beams
        return draw_sweep(grid, config, log_odds_update, threads, box)

    def _count(self, grid: OccupancyGrid, config: MappingConfig, threads: int, box: NDArray[np.int64]) -> int:
        """Count the hits and the misses of each cell: two maps, in each of which one of them counts 1."""
        count = 0
        for statistic, (miss, hit) in enumerate(((0.0, 1.0), (1.0, 0.0))):
            log_odds_update = (np.float32(miss), np.float32(hit), np.float32(-np.inf), np.float32(np.inf))
            count = self._draw(grid.with_statistic(statistic), config, log_odds_update, threads, box)
        return count

    def _add_certainties(self, grid: OccupancyGrid, config: MappingConfig, box: NDArray[np.int64]) -> int:
        count, _, _ = self.watch_certainties(grid, config, box, -1)
        return count

    def watch_certainties(
        self, grid: OccupancyGrid, config: MappingConfig, box: NDArray[np.int64], cell: int
    ) -> tuple[int, NDArray[np.int64], NDArray[np.float32]]:
        """Add all scans to the certainties of Moravec and Elfes.

        Return the number of cell updates and, of the cell with this number (−1: none), the readings that touched it, as
        :meth:`contributions`, and its certainties after each (n, 2): occupied, empty.
        """
        assert grid.cell_statistics is not None  # noqa: S101 - begun before
        occupied, empty = (statistic.reshape(-1) for statistic in grid.cell_statistics)
        room = 2 * self.ranges.size if cell >= 0 else 0
        contributions, certainties = np.empty((room, 2), np.int64), np.empty((room, 2), np.float32)
        count, n = add_certainties(
            occupied, empty, grid.observed.reshape(-1), grid.geometry.cols, *self.scans_on(grid.geometry),
            grid.geometry.frame, self.reading_filter(config), config.opening, box, cell, contributions, certainties,
        )  # fmt: skip
        return count, contributions[:n], certainties[:n]

    def contributions(
        self, geometry: GridGeometry, config: MappingConfig, row: int, col: int
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return the readings that touch a cell (n, 2) and the evidence of each (n,), log-odds.

        A reading is scan · n_beams + beam, and 1 for a hit or 0 for a miss.
        """
        if _is_wide(config):
            return contributions_in_cones(self, geometry, config, row, col)
        contributions = self._thin_touches(geometry, config, row, col)
        if config.model == "smooth_ramp":
            return contributions, ramp_increments(self, geometry, config, (row, col), contributions)
        miss, hit, _, _ = log_odds_update_of(config)
        return contributions, np.where(contributions[:, 1] == 1, hit, miss).astype(np.float32)

    def _thin_touches(self, geometry: GridGeometry, config: MappingConfig, row: int, col: int) -> NDArray[np.int64]:
        reading_filter, n_beams = self.reading_filter(config), self.ranges.shape[1]
        if config.update == "per_scan":
            out = np.empty((len(self.ranges), 2), dtype=np.int64)
            n = contributions_of_fields(*self.scans_on(geometry), geometry.frame, reading_filter, row, col, out)
            return out[:n]
        sifted, near = np.empty_like(self.ranges), np.empty(len(self.ranges), dtype=np.bool_)
        filter_readings_near_cell(
            self.ranges, self.sensors, self.beams, geometry.frame, reading_filter, row, col, sifted, near
        )
        sifted = sifted[near]
        planned = self._plan_beams(sifted, self.sensors[near], geometry, config, 1).planned
        out = np.empty((sifted.size, 2), dtype=np.int64)
        if config.traversal == "amanatides_woo":
            n = contributions_of_rays(planned, geometry.resolution, row, col, out)
        else:
            n = contributions_of_lines(planned, row, col, out)
        scans, beams = np.divmod(out[:n, 0], n_beams)
        out[:n, 0] = np.flatnonzero(near)[scans] * n_beams + beams
        return out[:n]

    def _chunks(self) -> list[slice]:
        """The scans in parts of about so many readings."""
        step = max(1, _CHUNK_READINGS // max(1, self.ranges.shape[1]))
        return [slice(first, min(first + step, len(self.ranges))) for first in range(0, len(self.ranges), step)]

    def _plan_beams(
        self,
        ranges: NDArray[np.float32],
        sensors: NDArray[np.float64],
        geometry: GridGeometry,
        config: MappingConfig,
        threads: int,
    ) -> _Plan:
        """Plan the beams of some scans."""
        n_beams = ranges.shape[1]
        work = np.zeros((threads, geometry.rows + 1))
        boxes = np.tile(np.array([geometry.rows, 0, geometry.cols, 0]), (threads, 1))
        plan, planned = _plan_space(config, ranges.size)
        view = (self.beams, geometry.frame, self.reading_filter(config))
        in_parallel(
            [
                partial(plan, ranges[a:b], sensors[a:b], *view, a * n_beams, planned, own_work, own_box)
                for (a, b), own_work, own_box in zip(shares(len(ranges), threads), work, boxes, strict=True)
            ]
        )
        boxes += [-1, 1, -1, 1]  # an endpoint may be rounded out of the line through it
        box = np.array(_joined(boxes, geometry)).reshape(4)
        return _Plan(planned, np.cumsum(work.sum(axis=0))[:-1], box)

    def _draw_beams(
        self,
        grid: OccupancyGrid,
        config: MappingConfig,
        log_odds_update: LogOddsUpdate,
        threads: int,
        box: NDArray[np.int64],
    ) -> int:
        frame, evidence, smooth = grid.geometry.frame, evidence_of(config), config.model == "smooth_ramp"
        flat = (grid.log_odds.reshape(-1), grid.observed.reshape(-1), grid.geometry.cols)
        count = 0
        for part in self._chunks():
            plan = self._plan_beams(self.ranges[part], self.sensors[part], grid.geometry, config, threads)
            if config.traversal == "amanatides_woo":
                draw = partial(draw_rays, *flat, plan.planned, frame[4], smooth, evidence, log_odds_update)
            elif smooth:
                ranges, sensors, reading_filter = self.ranges[part], self.sensors[part], self.reading_filter(config)
                draw = partial(
                    draw_ramps, *flat, plan.planned, ranges, sensors, frame, reading_filter, evidence, log_odds_update
                )
            else:
                draw = partial(draw_lines, *flat, plan.planned, log_odds_update)
            count += _in_bands(
                partial(_draw_with_observed, grid, plan, draw), plan.work, (0, len(plan.work)), threads, box
            )
        return count

    def _draw_fields(
        self,
        grid: OccupancyGrid,
        config: MappingConfig,
        log_odds_update: LogOddsUpdate,
        threads: int,
        box: NDArray[np.int64],
    ) -> int:
        count = 0
        for part in self._chunks():
            plan = plan_of_fields(self, part, grid.geometry, config, threads)
            if plan.rows[0] < plan.rows[1] and plan.words[0] < plan.words[1]:
                count += _in_bands(drawer_of_fields(plan, grid, log_odds_update), plan.work, plan.rows, threads, box)
        return count


def check_beam_length(metres: float, resolution: float) -> None:
    """Raise :class:`ConfigError` for cells so small that a beam of so many metres crosses too many of them."""
    if metres / resolution >= MAX_STEPS:
        raise ConfigError(
            "grid.resolution", f"A beam of {metres:g} m crosses {MAX_STEPS} cells or more; choose coarser ones."
        )


def _joined(boxes: NDArray[np.int64], geometry: GridGeometry) -> list[tuple[int, int]]:
    """Return the rows and the columns [first, stop) that hold all boxes, as far as they lie in the grid."""
    sides = zip(boxes[:, ::2].min(axis=0), boxes[:, 1::2].max(axis=0), geometry.shape, strict=True)
    return [(max(int(first), 0), min(int(stop), side)) for first, stop, side in sides]


def _is_wide(config: MappingConfig) -> bool:
    """Return whether the model's evidence differs all over a beam's field, so that cones are drawn."""
    return config.model in CONES or (config.model == "smooth_ramp" and config.update == "per_scan")


def _plan_space(config: MappingConfig, readings: int) -> tuple[Callable[..., None], NDArray[Any]]:
    """Return the kernel that plans the beams, and room for what it writes."""
    if config.traversal == "amanatides_woo":
        return plan_rays, np.empty((readings, RAY_FIELDS))
    return plan_lines, np.empty((LINE_FIELDS, readings), dtype=np.int32)


def _draw_with_observed(
    grid: OccupancyGrid, plan: _Plan, draw: Callable[..., int], row_low: int, row_high: int, box: NDArray[np.int64]
) -> int:
    """Draw a band, noting what was observed in the way that costs less for so many cells."""
    touched = plan.box.copy()
    touched[:2] = touched[:2].clip(row_low, row_high)
    cells = int((touched[1] - touched[0]) * (touched[3] - touched[2]))
    if plan.work[row_low:row_high].sum() < _ENCODE_ABOVE_UPDATES_PER_CELL * cells or not encode_unobserved(
        grid.log_odds, grid.observed, touched
    ):
        return draw(row_low, row_high, box, True)
    count = draw(row_low, row_high, box, False)
    decode_observed(grid.log_odds, grid.observed, touched)
    return count


def log_odds_update_of(config: MappingConfig) -> LogOddsUpdate:
    """Return the increments and the clamp as the kernels take them."""
    model = config.beam_model()
    low, high = (np.float32(limit) for limit in config.clamp_limits)
    return (np.float32(model.log_odds_miss), np.float32(model.log_odds_hit), low, high)


def _in_bands(
    draw: Draw, work: NDArray[np.float64], rows: tuple[int, int], threads: int, box: NDArray[np.int64]
) -> int:
    """Let ``draw(row_low, row_high, box)`` work on some rows, a band for each thread; return the sum of the counts.

    ``work`` (rows of the grid,) says what each row costs.
    """
    first, stop = rows
    parts = [(first + low, first + high, box.copy()) for low, high in bands(work[first:stop], threads)]
    counts = in_parallel([partial(draw, *part) for part in parts])
    for _, _, own in parts:
        box[::2] = np.minimum(box[::2], own[::2])
        box[1::2] = np.maximum(box[1::2], own[1::2])
    return sum(int(count) for count in counts)
