"""A prepared puzzle: the log with its fault, its initial map, and its repaired map."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid import OccupancyGrid
from mapper.grid.metrics import wall_points
from mapper.mapping.integrate import grid_for, integrate_parts
from mapper.mapping.parameters import MappingConfig
from mapper.puzzles.scoring import Measures, measures_of, repair_share, repair_shares
from mapper.puzzles.spoiling import Spoiled
from mapper.sensors.scan import ScanLog

MAX_READINGS = 1_000_000  #: of a puzzle's log, which is mapped each time a repair is checked


@dataclass(frozen=True, slots=True)
class Puzzle:
    """``shown`` is the log with its fault, ``start`` the initial parameters of its map.

    ``reference`` (n, 2) are points of the correct walls, metres; ``spoiled`` and ``repaired`` are the measures of the
    map initially and after repair. ``can_repair`` means that parameters can improve the map.
    """

    cause: str
    shown: ScanLog
    trajectory: str
    start: MappingConfig
    repair: Mapping[str, Any]
    repair_trajectory: str
    reference: NDArray[np.float64]
    spoiled: Measures
    repaired: Measures

    @property
    def can_repair(self) -> bool:
        """Whether other parameters or poses improve the map."""
        return bool(repair_shares(self.spoiled, self.repaired, self.spoiled))

    def shares(self, now: Measures) -> dict[str, float]:
        """Return :func:`repair_shares` of a map."""
        return repair_shares(self.spoiled, self.repaired, now)

    def share(self, now: Measures) -> float:
        """Return :func:`repair_share` of a map."""
        return repair_share(self.shares(now))

    def measured(
        self,
        values: Mapping[str, Any],
        trajectory: str,
        limits: Limits = DEFAULT_LIMITS,
        may_continue: Callable[[], bool] = lambda: True,
    ) -> Measures:
        """Return the measures of the map of all scans with other parameters. Raises the errors of :func:`mapped`."""
        grid = mapped(self.shown, MappingConfig(**dict(values)), trajectory, limits, may_continue)
        return measures_of(grid, self.reference)


def mapped(
    log: ScanLog,
    config: MappingConfig,
    trajectory: str,
    limits: Limits = DEFAULT_LIMITS,
    may_continue: Callable[[], bool] = lambda: True,
) -> OccupancyGrid:
    """Return the map of all scans of a log.

    Raises :class:`WorkCancelledError` once ``may_continue`` returns False, and :class:`mapper.core.errors.LimitError`
    for a map that is too large.
    """
    grid = grid_for(log, config, trajectory, limits=limits)
    for _ in integrate_parts(grid, log, config, trajectory, 0, log.n_scans):
        if not may_continue():
            raise WorkCancelledError("puzzle.unwanted", "The map is not wanted any more.")
    return grid


def puzzle_of(
    spoiled: Spoiled,
    cause: str,
    first: MappingConfig,
    limits: Limits = DEFAULT_LIMITS,
    may_continue: Callable[[], bool] = lambda: True,
    step: Callable[[float], None] = lambda _: None,
) -> Puzzle:
    """Return the puzzle of a faulty log; ``first`` are the parameters to which its values are applied.

    ``step`` is called with the completed fraction of the maps, 0 to 1. Raises the errors of :func:`mapped`.
    """
    step(0.0)
    start, repaired = first.with_values(spoiled.start), first.with_values(spoiled.repair)
    reference = mapped(
        spoiled.reference,
        first.with_values(spoiled.reference_values),
        spoiled.reference_trajectory,
        limits,
        may_continue,
    )
    step(1.0 / 3.0)
    walls = wall_points(reference)
    before = measures_of(mapped(spoiled.log, start, spoiled.trajectory, limits, may_continue), walls)
    step(2.0 / 3.0)
    after = measures_of(mapped(spoiled.log, repaired, spoiled.repaired_along, limits, may_continue), walls)
    changed = {name: value for name, value in asdict(repaired).items() if value != getattr(start, name)}
    return Puzzle(
        cause, spoiled.log, spoiled.trajectory, start, changed, spoiled.repair_trajectory, walls, before, after
    )


def shortened(log: ScanLog, most: int = MAX_READINGS) -> ScanLog:
    """Return a log's first scans, with at most ``most`` readings in total."""
    scans = max(2, most // max(1, log.n_beams))
    return log if log.n_scans <= scans else log.take(slice(0, scans))
