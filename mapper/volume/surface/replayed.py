"""Surface of the first scans of a sequence, replayed forward scan by scan and backward from the nearest snapshot."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array
from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.sensors.depth_image import DepthImage
from mapper.volume.blocks import BLOCK
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.surface.parameters import TsdfConfig
from mapper.volume.surface.tsdf import Fused, TsdfVolume


class MeasuredScans(Protocol):
    """Scans in order."""

    @property
    def has_origins(self) -> bool:
        """Whether the sensor position of all scans is known."""

    def __len__(self) -> int: ...

    def depth_image(self, index: int) -> DepthImage | None:
        """Return the depth image of a scan; None if it has points only."""

    def scan(self, index: int) -> PlacedScan:
        """Return the points of a scan."""


SNAPSHOT_BYTES = 128 << 20  #: of all snapshots of one surface
EVERY = 8  #: initial number of scans between snapshots; doubled each time the snapshots become too large


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The blocks of a surface: their ``codes`` (n,), ``distances`` and ``weights`` (n, 8, 8, 8)."""

    codes: Int64Array
    distances: Float32Array
    weights: Float32Array

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays."""
        return self.codes.nbytes + self.distances.nbytes + self.weights.nbytes


class ReplayedSurface:
    """A surface of the first ``index`` scans of ``source``, whose sensor positions must be known.

    Depth images are fused as such, other scans as points. ``counts`` has the number of blocks after each of these
    scans. Raises :class:`ConfigError` for a source without sensor positions.
    """

    def __init__(
        self, source: MeasuredScans, config: TsdfConfig, limits: Callable[[], Limits] | None = None,
        *, snapshot_bytes: int = SNAPSHOT_BYTES,
    ) -> None:  # fmt: skip
        if not source.has_origins:
            raise ConfigError(
                "tsdf.no_origin", "The file does not say where the sensor was, from which distances are measured."
            )
        self.source, self.config = source, config
        self._limits = limits or (lambda: DEFAULT_LIMITS)
        self._most_bytes, self._every = snapshot_bytes, EVERY
        self._snapshots: dict[int, Snapshot] = {}
        self.counts: list[int] = []
        self._begin(0)

    def _begin(self, index: int) -> None:
        self.index = index
        self.volume = TsdfVolume(self.config, self._limits())
        del self.counts[index:]
        if index:
            snapshot = self._snapshots[index]
            self.volume.set_blocks(snapshot.codes, snapshot.distances, snapshot.weights)
        self._touched: list[Int32Array] = []
        self._changed_all = True

    @property
    def count(self) -> int:
        """Number of scans."""
        return len(self.source)

    @property
    def snapshots(self) -> tuple[int, ...]:
        """Numbers of scans after which a snapshot is kept, ascending."""
        return tuple(sorted(self._snapshots))

    @property
    def n_cells(self) -> int:
        """Voxels for which the map and its snapshots have allocated memory; a voxel has a distance and a weight."""
        snapshots = sum(snapshot.nbytes for snapshot in self._snapshots.values())
        return 2 * self.volume.blocks.count * BLOCK**3 + snapshots // 4

    def take_touched(self) -> Int32Array | None:
        """Return the slots (n,) of the blocks that changed since the last call; None if any may have."""
        touched, changed_all = self._touched, self._changed_all
        self._touched, self._changed_all = [], False
        return None if changed_all else np.unique(np.concatenate([np.empty(0, np.int32), *touched]))

    def go_to(
        self, index: int, is_over: Callable[[], bool] = lambda: False, may_continue: Callable[[], bool] = lambda: True
    ) -> bool:
        """Compute the surface of the first ``index`` scans, or a part of the way; return whether it is reached.

        At least one scan is fused, and further ones until ``is_over``. Raises :class:`WorkCancelledError` between two
        scans unless ``may_continue``, and the errors of :meth:`TsdfVolume.fuse_depth` and
        :meth:`TsdfVolume.fuse_points`; the surface is then that of the scans before.
        """
        if index < self.index:
            snapshots = self.snapshots
            place = bisect_right(snapshots, index)
            self._begin(snapshots[place - 1] if place else 0)
        while self.index < index:
            if not may_continue():
                raise WorkCancelledError("tsdf.cancelled", f"The surface was cancelled after {self.index} scans.")
            self.volume.blocks.limits = self._limits()
            self._touched.append(fuse(self.volume, self.source, self.index).slots)
            self.index += 1
            self.counts.append(self.volume.blocks.count)
            self._keep()
            if is_over():
                break
        return self.index == index

    def _keep(self) -> None:
        """Keep a snapshot if due; if they are too large, drop every second one."""
        is_due = self._most_bytes > 0 and self.index % self._every == 0
        if not is_due or self.index in self._snapshots or self.index == self.count:
            return
        volume = self.volume
        copy = Snapshot(volume.blocks.codes.copy(), volume.distances.copy(), volume.weights.copy())
        self._snapshots[self.index] = copy
        while self._snapshots and sum(snapshot.nbytes for snapshot in self._snapshots.values()) > self._most_bytes:
            self._every *= 2
            self._snapshots = {at: snapshot for at, snapshot in self._snapshots.items() if at % self._every == 0}


def fuse(volume: TsdfVolume, source: MeasuredScans, index: int) -> Fused:
    """Update a surface by one scan of a sequence: by its depth image, or else by its points.

    Raises :class:`LimitError` like the methods of the volume.
    """
    image = source.depth_image(index)
    try:
        if image is not None:
            return volume.fuse_depth(image.depth, image.camera, image.pose)
        scan = source.scan(index)
        return volume.fuse_points(scan.points, np.asarray(scan.origin))
    except LimitError as error:
        raise LimitError(error.code, f"Scan {index + 1}: {error.message}") from error
