"""Plan of an update: parameters and sensor, resolved before any scan is read, and scans of several sensors in turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.mapping.kernels.bresenham import MAX_STEPS
from mapper.mapping.kernels.cones import FLAT, GAUSSIAN, RAMP
from mapper.mapping.kernels.moravec_elfes import add_certainties
from mapper.mapping.kernels.types import Cone, Evidence, LogOddsUpdate, ReadingFilter, Scans
from mapper.mapping.parameters import MappingConfig, ModelStrategy
from mapper.mapping.sensor_model import BeamModel


@dataclass(frozen=True, slots=True)
class UpdatePlan:
    """The parameters of :class:`mapper.mapping.parameters.MappingConfig` in the form that updates and kernels use.

    ``no_return`` "free" is part of ``reading_filter``; "hit" is ``no_return_is_hit``. ``clamp`` is (ℓ_min, ℓ_max),
    infinite without a clamp. ``mount`` is the pose (m, m, rad) that is composed onto the sensor's. ``deskew`` is "off"
    for updates that process all beams of a scan together. ``time_offset``, seconds, is added to the stamps of the
    scans. With ``only_hits`` the misses of a scan are ignored in the cells that it hits.
    """

    strategy: ModelStrategy
    model: BeamModel
    reading_filter: ReadingFilter
    log_odds_update: LogOddsUpdate
    evidence: Evidence
    cone: Cone
    update: str
    exact_rays: bool
    no_return_is_hit: bool
    only_hits: bool
    clamp: tuple[float, float]
    mount: tuple[float, float, float]
    upside_down: bool
    deskew: str
    time_offset: float

    @property
    def per_scan(self) -> bool:
        """Whether each cell is updated once per scan, by the beam whose field contains it."""
        return self.update == "per_scan" and self.strategy.per_scan

    @property
    def draws_cones(self) -> bool:
        """Whether the evidence varies within a beam's field, so that the cone kernels draw it."""
        return self.strategy.cone or (self.strategy.smooth and self.per_scan)

    @property
    def sees_fields(self) -> bool:
        """Whether a beam updates cells off its axis."""
        return self.strategy.cone or self.per_scan

    @property
    def beam_length(self) -> float:
        """Distance from the sensor to the far end of the hit window of the longest reading, metres."""
        return self.reading_filter.range_max + self.model.half_window(self.reading_filter.range_max)


@lru_cache(maxsize=256)  # a simulation maps each scan separately
def plan_update(config: MappingConfig, range_min: float, range_max: float) -> UpdatePlan:
    """Return the plan for a sensor with readings from ``range_min`` to ``range_max``, metres."""
    strategy, model = config.strategy, config.beam_model()
    growth = 4.0 * config.sigma_growth if strategy.smooth else 0.0
    gaussian = GAUSSIAN if config.cone_profile == "gaussian" else FLAT
    low, high = config.clamp_limits
    scan_by_scan = strategy.statistics == "certainties" or (config.update == "per_scan" and strategy.per_scan)
    return UpdatePlan(
        strategy,
        model,
        ReadingFilter(
            float(range_min),
            float(min(range_max, config.range_max)),
            2.0 * model.half_window(0.0),
            growth,
            config.no_return == "free",
        ),
        LogOddsUpdate(
            np.float32(model.log_odds_miss), np.float32(model.log_odds_hit), np.float32(low), np.float32(high)
        ),
        Evidence(model.log_odds_miss, model.log_odds_hit),
        Cone(RAMP if strategy.smooth else gaussian, config.opening, strategy.smooth),
        config.update,
        config.traversal == "amanatides_woo",
        config.no_return == "hit",
        config.only_hits,
        (low, high),
        config.mount,
        config.mount_upside_down,
        "off" if scan_by_scan else config.deskew,
        config.time_offset,
    )


def check_beam_length(metres: float, resolution: float) -> None:
    """Raise :class:`ConfigError` if a beam of ``metres`` crosses too many cells of ``resolution`` metres."""
    if metres / resolution >= MAX_STEPS:
        raise ConfigError(
            "grid.resolution", f"A beam of {metres:g} m crosses {MAX_STEPS} cells or more; choose coarser ones."
        )


def part_of(scans: Scans, start: int, stop: int) -> Scans:
    """Return the scans [start, stop) as views."""
    part = slice(start, stop)
    return scans._replace(
        ranges=scans.ranges[part],
        sensors=scans.sensors[part],
        headings=scans.headings[part],
        numbers=scans.numbers[part],
    )


Run = tuple[int, int, int]  #: a sensor's index, and its scans [first, stop)


@dataclass(frozen=True, slots=True)
class Turns:
    """The scans of each of ``sensors`` with the plan of their update, and the ``runs`` in which they alternate.

    Each scan of a sensor occurs once, in order.
    """

    sensors: Sequence[tuple[Scans, UpdatePlan]]
    runs: Sequence[Run]

    @classmethod
    def of_one(cls, scans: Scans, plan: UpdatePlan) -> Turns:
        """Return the scans of one sensor."""
        return cls([(scans, plan)], [(0, 0, len(scans.ranges))])

    @property
    def readings(self) -> int:
        """Number of readings."""
        return sum(scans.ranges.size for scans, _ in self.sensors)

    @property
    def pieces(self) -> list[tuple[Scans, UpdatePlan]]:
        """The scans of each run, with their plan."""
        return [(part_of(self.sensors[k][0], first, stop), self.sensors[k][1]) for k, first, stop in self.runs]


def update_certainties(
    grid: OccupancyGrid, scans: Scans, plan: UpdatePlan, box: NDArray[np.int64], watched: int = -1
) -> tuple[int, NDArray[np.int64], NDArray[np.float32]]:
    """Add all scans to the certainties in ``grid.cell_statistics``; extend ``box`` (4,) to the touched cells.

    This is the update of Moravec and Elfes, scan by scan on one thread. Return the number of cell updates, the readings
    (n, 2) that touched the cell ``watched`` (row · cols + col, −1: none), as in
    :func:`mapper.mapping.provenance.contributions`, and its certainties after each reading (n, 2): occupied, empty.
    """
    assert grid.cell_statistics is not None  # noqa: S101 - begun before
    occupied, empty = (statistic.reshape(-1) for statistic in grid.cell_statistics)
    room = 2 * scans.ranges.size if watched >= 0 else 0
    touches, certainties = np.empty((room, 2), np.int64), np.empty((room, 2), np.float32)
    count, n = add_certainties(
        occupied, empty, grid.observed.reshape(-1), grid.geometry.cols, scans,
        grid.geometry.frame, plan.reading_filter, plan.cone.opening, box, watched, touches, certainties,
    )  # fmt: skip
    return count, touches[:n], certainties[:n]
