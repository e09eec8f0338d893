"""Incremental replay of a log's map with any parameters, with checkpointed seek."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields

import numpy as np

from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.parallel import single_threaded
from mapper.grid import TILE, CellBox, OccupancyGrid
from mapper.mapping.integrate import Bounds, Change, bounds_of_log, grid_for, integrate_scans, scans_at_once
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import Provenance, provenance
from mapper.replay.checkpoints import Checkpoints
from mapper.sensors.scan import ScanLog

#: Parameters that change the values of cells but not the extent of a log. Any other one is part of the key.
WITHOUT_EFFECT = frozenset({
    "log_odds_hit", "log_odds_miss", "p_free", "p_occ", "cone_profile", "prior_weight", "hit_and_passed", "traversal",
    "clamp", "log_odds_min", "log_odds_max", "log_odds_prior",
})  # fmt: skip
BOUNDS_KEPT = 8  #: bounds kept
COSTLY = ("model", "update", "no_return", "deskew", "resolution")  #: parameters that affect the cost of a scan
PART_READINGS = 1 << 22  #: maximum number of readings added at once
FIRST_READINGS = 1 << 9  #: the same before the number of cells per reading is known
MOST_UPDATES = 1 << 36  #: cell updates up to which checkpoints are prefetched: one or two minutes on one core

_BOUNDS_KEY = tuple(field.name for field in fields(MappingConfig) if field.name not in WITHOUT_EFFECT)


class BoundsCache:
    """Computes the bounds of a log (:func:`mapper.mapping.integrate.bounds_of_log`) once per set of parameters.

    It serves one log, and keeps the most recently requested bounds.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], Bounds] = {}

    def __call__(self, log: ScanLog, config: MappingConfig, trajectory: str | None) -> Bounds:
        """Return the minimum and maximum x, y (2,), metres, of everything that ``log`` observes with ``config``."""
        key = (trajectory, *(getattr(config, name) for name in _BOUNDS_KEY))
        bounds = self._known.pop(key, None)
        if bounds is None:
            bounds = bounds_of_log(log, config, trajectory)
        self._known[key] = bounds  # the newest is last
        if len(self._known) > BOUNDS_KEPT:
            del self._known[next(iter(self._known))]
        return bounds


class IncrementalReplay:
    """The map of the first :attr:`index` scans of a log, which can be brought to any other number of scans.

    It stores checkpoints, and continues from one of them if that is less work. ``grid`` is initially empty and covers
    everything the log observes; it stays the same object. Not thread-safe, but replays in several threads may share
    their checkpoints.
    """

    def __init__(
        self,
        log: ScanLog,
        config: MappingConfig,
        trajectory: str,
        grid: OccupancyGrid,
        checkpoints: Checkpoints | None = None,
    ) -> None:
        self.log, self.config, self.trajectory, self.grid = log, config, trajectory, grid
        self.checkpoints = checkpoints or Checkpoints(config)
        self.index = 0  #: scans in the map
        self._scans, self._updates = 0, 0  # added so far
        self._in_time: int | None = None  # scans per step that keep it short; None: not known yet
        self._begin(0)

    def _begin(self, moment: int) -> None:
        """Record that the map is at a stored moment."""
        tiles = [-(-side // TILE) for side in self.grid.geometry.shape]
        self._since = moment
        self._updates_since = 0
        self._touched = np.zeros(tiles, dtype=np.bool_)  # tiles that may have changed since

    def go_to(
        self, index: int, may_continue: Callable[[], bool] = lambda: True, enough: Callable[[], bool] = lambda: False
    ) -> Change:
        """Bring the map to ``index`` scans, or part of the way until ``enough`` returns True after a step.

        Raises :class:`WorkCancelledError` if ``may_continue``, called between steps, returns False.
        """
        moment = self.checkpoints.before(index)
        box = self._restore(moment) if index < self.index or moment > self.index else None
        count = 0
        while self.index < index:
            if not may_continue():
                raise WorkCancelledError("replay.unwanted", "The map is not wanted any more.")
            change = self.step(index)
            count += change.cells_updated
            box = change.box if box is None else box if change.box is None else box | change.box
            if enough():
                break
        return Change(box, geometry_changed=False, cells_updated=count)

    def _restore(self, moment: int) -> CellBox | None:
        box = self.checkpoints.restore(self.grid, self._touched, self._since, moment)
        self.index = moment
        self._begin(moment)
        return box

    def step(self, last: int) -> Change:
        """Add some scans, some hundredths of a second of work and not beyond ``last``; store a checkpoint if due."""
        checkpoints = self.checkpoints
        stop = checkpoints.after(self.index, min(self.index + self._scans_at_once(), last))
        began = time.thread_time()
        change = integrate_scans(self.grid, self.log, self.config, self.trajectory, self.index, stop)
        self._in_time = scans_at_once(stop - self.index, time.thread_time() - began)
        self._scans += stop - self.index
        self._updates += change.cells_updated
        self._updates_since += change.cells_updated
        self.index = stop
        if change.box is not None:
            self._touched[_tiles_of(change.box)] = True
        checkpoints.reached = max(checkpoints.reached, stop)
        if checkpoints.before(stop) == stop or (
            checkpoints.is_due(self._updates_since, self._touched) and checkpoints.keep(self.grid, self._touched, stop)
        ):
            self._begin(stop)
        return change

    @property
    def updates_per_scan(self) -> float | None:
        """Mean number of cell updates per scan so far; None before the first scan."""
        return self._updates / self._scans if self._scans else None

    def expect_as(self, other: IncrementalReplay) -> None:
        """Use the cost of a scan from another replay until this one has measured it."""
        self._scans, self._updates, self._in_time = other._scans, other._updates, other._in_time

    def _scans_at_once(self) -> int:
        rate, most = self.updates_per_scan, PART_READINGS // self.log.n_beams
        if rate is None:
            due = FIRST_READINGS // self.log.n_beams
        else:
            spacing = self.checkpoints.spacing
            due = int(max(spacing - self._updates_since, spacing // 4) / max(rate, 1.0))
        return max(1, min(due, most, most if self._in_time is None else self._in_time))


def _tiles_of(box: CellBox) -> tuple[slice, slice]:
    return np.s_[box.row0 // TILE : -(-box.row1 // TILE), box.col0 // TILE : -(-box.col1 // TILE)]


class CheckpointPrefetcher:
    """Creates the checkpoints that a replay has not reached yet, on a separate grid, in idle time.

    For one thread at a time, which may differ from that of the replay.
    """

    def __init__(self, replay: IncrementalReplay) -> None:
        self._follows = replay
        self._replay: IncrementalReplay | None = None  # created by the stepping thread, because a large grid takes time

    @staticmethod
    def is_worth(replay: IncrementalReplay) -> bool:
        """Return whether the rest of the log is noticeable work, but at most :data:`MOST_UPDATES`."""
        checkpoints, rate = replay.checkpoints, replay.updates_per_scan
        return (
            rate is not None and checkpoints.spacing < rate * (replay.log.n_scans - checkpoints.reached) < MOST_UPDATES
        )

    def step(self) -> bool:
        """Work for some hundredths of a second, on this thread only; return whether work remains."""
        replay = self._replay = self._replay or self._begin()
        with single_threaded():
            newest = replay.checkpoints.newest
            if newest > replay.index:  # reached by another replay
                replay.go_to(newest)
            elif replay.index < replay.log.n_scans:
                replay.step(replay.log.n_scans)
        return replay.index < replay.log.n_scans

    def _begin(self) -> IncrementalReplay:
        replay = self._follows
        own = IncrementalReplay(replay.log, replay.config, replay.trajectory, replay.grid.emptied(), replay.checkpoints)
        own.expect_as(replay)
        return own


class Replay:
    """The map of the first :attr:`index` scans of a log.

    The grid covers everything the whole log observes from the start, so its geometry does not change during the replay.
    Not thread-safe. With ``prior``, a map of the same place, mapping continues from it, on its lattice. Raises the
    errors of :func:`mapper.mapping.integrate.grid_for`; the replay is unchanged after an error.
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
        self.may_continue: Callable[[], bool] = lambda: True  #: called between steps: False cancels the computation

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
        """The map; replaced by another object only by other parameters."""
        return self._replay.grid

    @property
    def bounds(self) -> Bounds:
        """Minimum and maximum x, y (2,), metres, of everything the log observes with the current parameters."""
        return self._bounds(self.log, self.config, self.trajectory)

    @property
    def index(self) -> int:
        """Number of scans in the map."""
        return self._replay.index

    def advance_to(self, index: int, enough: Callable[[], bool] = lambda: False) -> Change:
        """Bring the map to ``index`` scans, from its state or from a checkpoint, whichever is less work.

        ``enough`` is called after each step, some hundredths of a second of work. If it returns True, the map stays at
        fewer scans, and another call continues. Raises :class:`ConfigError` for an index that the log does not have,
        and :class:`mapper.core.errors.WorkCancelledError` if :attr:`may_continue` returns False.
        """
        if not 0 <= index <= self.log.n_scans:
            raise ConfigError("replay.index", f"The log has {self.log.n_scans} scans; there is no map after {index}.")
        return self._go(self._replay, index, enough)

    def _go(self, replay: IncrementalReplay, index: int, enough: Callable[[], bool] = lambda: False) -> Change:
        self._under_way = (replay, index)
        try:
            return replay.go_to(index, self.may_continue, enough)
        finally:
            self._under_way = None

    @property
    def fraction(self) -> float | None:
        """Completed fraction of the running computation, 0 to 1; None if none is running."""
        under_way = self._under_way
        return None if under_way is None else min(1.0, under_way[0].index / max(1, under_way[1]))

    def reconfigure(self, config: MappingConfig) -> Change:
        """Recompute the whole map with other parameters, at the same index."""
        replay = self._new_replay(self.log, config)
        if all(getattr(config, name) == getattr(self.config, name) for name in COSTLY):
            replay.expect_as(self._replay)
        change = self._go(replay, self.index)
        geometry_changed = replay.grid.geometry != self.grid.geometry
        self._replay = replay
        rows, cols = replay.grid.geometry.shape
        return Change(CellBox(0, rows, 0, cols), geometry_changed, change.cells_updated)

    def adopt(self, log: ScanLog) -> bool:
        """Continue with ``log``, the same scans with other trajectories, if that does not change the map of the current
        scans.

        That is the case if the poses used for it and its checkpoints are equal in both logs, and the grid covers
        everything the log observes. Return whether it is; otherwise nothing changes.
        """
        old, new = (log_.trajectory(self.trajectory).known_poses for log_ in (self.log, log))
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
        """Return a prefetcher of the checkpoints that this replay lacks; None if that is not worthwhile."""
        return CheckpointPrefetcher(self._replay) if CheckpointPrefetcher.is_worth(self._replay) else None

    def provenance(self, row: int, col: int) -> Provenance:
        """Return every beam that touched a cell of the current map, with the evidence it added.

        Raises :class:`ConfigError` for a cell outside the grid.
        """
        inside = self.grid.geometry.contains((row, col)) and self.grid.prior_map is not None
        prior = float(self.grid.prior()[row, col]) if inside else None
        return provenance(
            self.grid.geometry, self.log, self.config, (row, col), self.trajectory, self.index, prior=prior
        )
