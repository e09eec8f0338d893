"""Incremental replay of a log's map with checkpointed seek."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from mapper.core.errors import WorkCancelledError
from mapper.core.parallel import single_threaded
from mapper.grid import TILE, CellBox, OccupancyGrid
from mapper.mapping.integrate import Change, integrate_scans, scans_at_once
from mapper.mapping.parameters import MappingConfig
from mapper.replay.checkpoints import Checkpoints
from mapper.sensors.scan import ScanLog

PART_READINGS = 1 << 22  #: readings that are added at once, at most
FIRST_READINGS = 1 << 9  #: the same before it is known how many cells each of them touches
MOST_UPDATES = 1 << 36  #: cell updates up to which checkpoints are prefetched: one or two minutes of one core


class IncrementalReplay:
    """The map of the first :attr:`index` scans of a log, which can be brought to any other number of scans.

    It keeps checkpoints, and continues from one of them where that is less work. ``grid`` is initially empty and
    contains all that the log sees; it stays the same object. Not for several threads at once, but replays of several
    threads may share their checkpoints.
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
        self._in_time: int | None = None  # scans that a step may add without taking too long; None: not known yet
        self._begin(0)

    def _begin(self, moment: int) -> None:
        """Note that the map is as it was kept at a moment."""
        tiles = [-(-side // TILE) for side in self.grid.geometry.shape]
        self._since = moment
        self._updates_since = 0
        self._touched = np.zeros(tiles, dtype=np.bool_)  # tiles that may have changed since

    def go_to(
        self, index: int, wanted: Callable[[], bool] = lambda: True, enough: Callable[[], bool] = lambda: False
    ) -> Change:
        """Bring the map to ``index`` scans, or on the way there up to the step after which ``enough`` returns True.

        Raises :class:`WorkCancelledError` where ``wanted``, called between steps, returns False.
        """
        moment = self.checkpoints.before(index)
        box = self._restore(moment) if index < self.index or moment > self.index else None
        count = 0
        while self.index < index:
            if not wanted():
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
        """Add some scans, some hundredths of a second's work and not beyond ``last``; keep a checkpoint where due."""
        kept = self.checkpoints
        stop = kept.after(self.index, min(self.index + self._scans_at_once(), last))
        began = time.thread_time()
        change = integrate_scans(self.grid, self.log, self.config, self.trajectory, self.index, stop)
        self._in_time = scans_at_once(stop - self.index, time.thread_time() - began)
        self._scans += stop - self.index
        self._updates += change.cells_updated
        self._updates_since += change.cells_updated
        self.index = stop
        if change.box is not None:
            self._touched[_tiles_of(change.box)] = True
        kept.reached = max(kept.reached, stop)
        if kept.before(stop) == stop or (
            kept.is_due(self._updates_since, self._touched) and kept.keep(self.grid, self._touched, stop)
        ):
            self._begin(stop)
        return change

    @property
    def updates_per_scan(self) -> float | None:
        """Mean number of cell updates per scan so far; None before the first scan."""
        return self._updates / self._scans if self._scans else None

    def expect_as(self, other: IncrementalReplay) -> None:
        """Take the cost of a scan from another replay until this one has measured it."""
        self._scans, self._updates, self._in_time = other._scans, other._updates, other._in_time

    def _scans_at_once(self) -> int:
        rate, most = self.updates_per_scan, PART_READINGS // self.log.n_beams
        if rate is None:
            due = FIRST_READINGS // self.log.n_beams
        else:
            spacing = self.checkpoints.spacing
            due = int(max(spacing - self._updates_since, spacing // 4) / max(rate, 1.0))
        return max(1, min(due, most, most if self._in_time is None else self._in_time))


class CheckpointPrefetcher:
    """Makes the checkpoints that a replay has not reached yet, on a grid of its own, in idle time.

    For one thread at a time, which need not be that of the replay.
    """

    def __init__(self, replay: IncrementalReplay) -> None:
        self._follows = replay
        self._replay: IncrementalReplay | None = None  # made by the thread that steps: a large grid takes time

    @staticmethod
    def is_worth(replay: IncrementalReplay) -> bool:
        """Whether the rest of the log is enough work to be noticed, but at most :data:`MOST_UPDATES`."""
        kept, rate = replay.checkpoints, replay.updates_per_scan
        return rate is not None and kept.spacing < rate * (replay.log.n_scans - kept.reached) < MOST_UPDATES

    def step(self) -> bool:
        """Work for some hundredths of a second, on this thread alone; return whether something is left to do."""
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


def _tiles_of(box: CellBox) -> tuple[slice, slice]:
    return np.s_[box.row0 // TILE : -(-box.row1 // TILE), box.col0 // TILE : -(-box.col1 // TILE)]
