"""Map of the first scans of a sequence, replayed forward scan by scan; backward steps start again."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mapper.core.array_types import Int32Array
from mapper.core.errors import LimitError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.volume.blocks import BLOCK
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.occupancy.volume import OccupancyVolume
from mapper.volume.octree.files import OctreeFile
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.scan_sequence import ScanSequence
from mapper.volume.scans.sources import Insertion


class ReplayedVolume:
    """A map of ``source``, the scans of a sequence or an octree, which counts as one scan.

    ``index`` scans are in ``volume``; ``inserted`` has their counts.
    """

    def __init__(
        self, source: ScanSequence | OctreeFile, config: VolumeConfig, limits: Callable[[], Limits] | None = None
    ) -> None:
        self.source, self.config = source, config
        self._limits = limits or (lambda: DEFAULT_LIMITS)
        self._begin()
        self.changed_all = True

    def _begin(self) -> None:
        self.index = 0
        self.volume = OccupancyVolume(self.config, self._limits())
        self.inserted = Insertion()
        self._touched: list[Int32Array] = []
        self.changed_all = True  #: whether any block may have changed since :meth:`take_touched`

    @property
    def count(self) -> int:
        """Number of scans."""
        return len(self.source) if isinstance(self.source, ScanSequence) else 1

    def placed_scans(self) -> Iterator[PlacedScan]:
        """Yield the scans that are in the map; none for an octree, whose scans are unknown."""
        if isinstance(self.source, ScanSequence):
            yield from map(self.source.scan, range(self.index))

    def take_touched(self) -> Int32Array | None:
        """Return the slots (n,) of the blocks that changed since the last call; None if any may have."""
        touched = self._touched
        changed_all, self._touched, self.changed_all = self.changed_all, [], False
        if changed_all:
            return None
        return np.unique(np.concatenate([np.empty(0, np.int32), *touched]))

    def go_to(
        self, index: int, is_over: Callable[[], bool] = lambda: False, may_continue: Callable[[], bool] = lambda: True
    ) -> bool:
        """Build the map of the first ``index`` scans, or a part of it once ``is_over``; return whether it is complete.

        At least one scan is inserted. Raises :class:`WorkCancelledError` between two scans unless ``may_continue``, and
        the errors of :meth:`OccupancyVolume.insert_scan`; the map may then contain a part of a scan and is rebuilt.
        """
        if index < self.index:
            self._begin()
        while self.index < index:
            if not may_continue():
                raise WorkCancelledError("volume.cancelled", f"The map was cancelled after {self.index} scans.")
            try:
                self._insert(self.index)
            except LimitError:
                self._begin()
                raise
            self.index += 1
            if is_over():
                break
        return self.index == index

    def _insert(self, index: int) -> None:
        if not isinstance(self.source, ScanSequence):
            self.volume = self.source.tree.volume(self.config, self._limits())
            self.changed_all = True
            return
        before = self.inserted.last_ns
        scan = self.source.scan(index)
        done = self.inserted.insert(self.volume, scan)
        self.volume.blocks.limits = self._limits()
        if self.config.half_life > 0.0 and before != self.inserted.last_ns:
            self.changed_all = True
        else:
            self._touched.append(done.slots)

    @property
    def n_cells(self) -> int:
        """Voxels for which the map has allocated memory."""
        return self.volume.blocks.count * BLOCK**3
