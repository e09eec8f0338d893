"""A log's map at any moment, with any parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid import CellBox, OccupancyGrid
from mapper.mapping.integrate import Bounds, Change, bounds_of_log, grid_for
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import Provenance, provenance
from mapper.replay.incremental import CheckpointPrefetcher, IncrementalReplay
from mapper.sensors.scan import ScanLog

#: Parameters that change the values of cells but not which place a log sees. Any other one is part of the key.
WITHOUT_EFFECT = frozenset({
    "log_odds_hit", "log_odds_miss", "p_free", "p_occ", "cone_profile", "prior_weight", "hit_and_passed", "traversal",
    "clamp", "log_odds_min", "log_odds_max", "log_odds_prior",
})  # fmt: skip
BOUNDS_KEPT = 8  #: bounds kept

_BOUNDS_KEY = tuple(field.name for field in fields(MappingConfig) if field.name not in WITHOUT_EFFECT)


class BoundsCache:
    """Computes the bounds of a log (:func:`mapper.mapping.integrate.bounds_of_log`) once per set of parameters.

    It serves one log, and keeps the bounds that were requested last.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], Bounds] = {}

    def __call__(self, log: ScanLog, config: MappingConfig, trajectory: str | None) -> Bounds:
        """Return the least and the greatest x, y (2,), metres, of all that ``log`` sees with ``config``."""
        key = (trajectory, *(getattr(config, name) for name in _BOUNDS_KEY))
        found = self._known.pop(key, None)
        if found is None:
            found = bounds_of_log(log, config, trajectory)
        self._known[key] = found  # the newest is last
        if len(self._known) > BOUNDS_KEPT:
            del self._known[next(iter(self._known))]
        return found


COSTLY = ("model", "update", "no_return", "deskew", "resolution")  #: parameters on which it depends what a scan costs


class Replay:
    """The map of the first :attr:`index` scans of a log.

    The grid covers from the start all that the whole log sees, so its geometry does not change during the replay. Not
    for several threads at once. With ``prior``, a map of the same place, mapping continues from it, on its lattice.
    Raises as :func:`mapper.mapping.integrate.grid_for` does; after an error the replay is as
    it was before.
    """

    def __init__(
        self,
        log: ScanLog,
        config: MappingConfig | None = None,
        trajectory: str | None = None,
        limits: Limits = DEFAULT_LIMITS,
        prior: OccupancyGrid | None = None,
    ) -> None:
        self._limits = limits
        self._prior = prior
        self._bounds = BoundsCache()
        self.trajectory = trajectory or log.default_trajectory
        self._replay = self._new_replay(log, MappingConfig() if config is None else config)
        self._under_way: tuple[IncrementalReplay, int] | None = None
        self.wanted: Callable[[], bool] = lambda: True  #: called between steps: False cancels the computation

    def _new_replay(self, log: ScanLog, config: MappingConfig) -> IncrementalReplay:
        grid = grid_for(log, config, self.trajectory, self._limits, self._prior, self._bounds)
        return IncrementalReplay(log, config, self.trajectory, grid)

    @property
    def log(self) -> ScanLog:
        """The log."""
        return self._replay.log

    @property
    def config(self) -> MappingConfig:
        """The parameters."""
        return self._replay.config

    @property
    def grid(self) -> OccupancyGrid:
        """The map; another object only after other parameters."""
        return self._replay.grid

    @property
    def index(self) -> int:
        """Scans in the map."""
        return self._replay.index

    def advance_to(self, index: int, enough: Callable[[], bool] = lambda: False) -> Change:
        """Bring the map to ``index`` scans, from where it is or from a checkpoint, whichever is less work.

        ``enough`` is called after each step, some hundredths of a second's work: where it returns True the map stays
        where it is by then, that of fewer scans, and another call goes on. Raises :class:`ConfigError` for an index
        that the log does not have, and :class:`mapper.core.errors.WorkCancelledError` where :attr:`wanted` returns
        False.
        """
        if not 0 <= index <= self.log.n_scans:
            raise ConfigError("replay.index", f"The log has {self.log.n_scans} scans; there is no map after {index}.")
        return self._go(self._replay, index, enough)

    def _go(self, replay: IncrementalReplay, index: int, enough: Callable[[], bool] = lambda: False) -> Change:
        self._under_way = (replay, index)
        try:
            return replay.go_to(index, self.wanted, enough)
        finally:
            self._under_way = None

    @property
    def fraction(self) -> float | None:
        """The completed share of the computation that is running, 0 to 1; None while none is."""
        under_way = self._under_way
        return None if under_way is None else min(1.0, under_way[0].index / max(1, under_way[1]))

    def reconfigure(self, config: MappingConfig) -> Change:
        """Make the whole map again with other parameters, at the same index."""
        replay = self._new_replay(self.log, config)
        if all(getattr(config, name) == getattr(self.config, name) for name in COSTLY):
            replay.expect_as(self._replay)
        change = self._go(replay, self.index)
        geometry_changed = replay.grid.geometry != self.grid.geometry
        self._replay = replay
        rows, cols = replay.grid.geometry.shape
        return Change(CellBox(0, rows, 0, cols), geometry_changed, change.cells_updated)

    def adopt(self, log: ScanLog) -> bool:
        """Go on with ``log``, the same scans with other trajectories, if the map of the present scans stays as it is.

        It does where the poses that it and its checkpoints were made with are equal in both, and where the grid holds
        all that the log sees. Return whether it does; otherwise nothing changes.
        """
        old, new = (one.trajectory(self.trajectory).known_poses for one in (self.log, log))
        if not np.array_equal(old, new, equal_nan=True):
            used = max(self.index, self._replay.checkpoints.reached) + 1  # deskewing uses the pose of the next scan
            if not np.array_equal(old[:used], new[:used], equal_nan=True):
                return False
            bounds = BoundsCache()
            low, high = bounds(log, self.config, self.trajectory)
            if not self.grid.geometry.contains(self.grid.geometry.world_to_cell(np.stack([low, high]))).all():
                return False
            self._bounds = bounds
        self._replay.log = log
        return True

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return a prefetcher of the checkpoints that this replay lacks; None where that is not worth while."""
        return CheckpointPrefetcher(self._replay) if CheckpointPrefetcher.is_worth(self._replay) else None

    def provenance(self, row: int, col: int) -> Provenance:
        """Return every beam that touched a cell of the present map, with the evidence that it added.

        Raises :class:`ConfigError` for a cell outside the grid.
        """
        inside = self.grid.geometry.contains((row, col)) and self.grid.prior_map is not None
        prior = float(self.grid.prior()[row, col]) if inside else None
        return provenance(
            self.grid.geometry, self.log, self.config, (row, col), self.trajectory, self.index, prior=prior
        )
