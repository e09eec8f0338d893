"""Checkpoints of a map, so that returning to one requires no mapping.

A moment is the map of the first k scans. For each moment only the tiles touched since the moment before are stored,
with lossless compression: the tile of a moment is its newest version up to then, or its initial state if it has none.
So many moments of a large map take little more memory than the map itself.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from threading import Lock

import numpy as np
import zstandard
from numpy.typing import NDArray

from mapper.core.zstd import compressed
from mapper.grid import TILE, CellBox, OccupancyGrid
from mapper.mapping import cell_statistics
from mapper.mapping.parameters import MappingConfig

BUDGET_BYTES = 8 << 20  #: for all moments of one map
SPACING = 1 << 24  #: cell updates between two moments: about a hundredth of a second of work
WORTH_KEEPING = 32  #: minimum cell updates per stored cell, so that storing costs a small fraction of mapping
ZSTD_LEVEL = 1
_OVERHEAD_BYTES = 100  # Python's overhead for a small bytes object

Tile = tuple[int, int]  # row and column of a tile
Part = tuple[slice, slice]


class Checkpoints:
    """The moments of one map, for one log, trajectory, geometry and ``config``. Thread-safe.

    In the methods, ``touched`` (tile rows, tile cols) bool are the tiles that may differ from a moment.
    """

    def __init__(self, config: MappingConfig) -> None:
        self.config = config
        self.spacing = SPACING  #: cell updates between two moments; grows if there is no room for all
        self.reached = 0  #: the last number of scans that any map reached
        self._moments: list[int] = []
        self._versions: dict[
            Tile, dict[int, bytes]
        ] = {}  # contents of each tile at the moments up to which it was touched
        self._bytes = 0
        self._lock = Lock()

    @property
    def moments(self) -> tuple[int, ...]:
        """The stored moments except 0, in order."""
        with self._lock:
            return tuple(self._moments)

    @property
    def nbytes(self) -> int:
        """Approximate number of bytes stored."""
        return self._bytes

    @property
    def newest(self) -> int:
        """The last moment; 0 if none is stored."""
        with self._lock:
            return self._moments[-1] if self._moments else 0

    def before(self, index: int) -> int:
        """Return the last moment up to ``index``."""
        with self._lock:
            place = bisect_right(self._moments, index)
            return self._moments[place - 1] if place else 0

    def after(self, index: int, last: int) -> int:
        """Return the first moment after ``index``, at most ``last``."""
        with self._lock:
            place = bisect_right(self._moments, index)
            return min(self._moments[place], last) if place < len(self._moments) else last

    def is_due(self, updates: int, touched: NDArray[np.bool_]) -> bool:
        """Return whether the cell updates since the last moment, and their tiles, justify another one."""
        return updates >= max(self.spacing, WORTH_KEEPING * TILE * TILE * int(np.count_nonzero(touched)))

    def keep(self, grid: OccupancyGrid, touched: NDArray[np.bool_], index: int) -> bool:
        """Store the map of ``index`` scans, unless a later moment is stored already; return whether it is now stored.

        ``touched`` is relative to any stored moment.
        """
        compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)
        tiles = _listed(touched)
        packed = [compressed(compressor, _packed(grid, _cells_of(tile))) for tile in tiles]
        with self._lock:
            if self._moments and index <= self._moments[-1]:
                return index in self._moments
            self._moments.append(index)
            for tile, data in zip(tiles, packed, strict=True):
                self._versions.setdefault(tile, {})[index] = data
                self._bytes += len(data) + _OVERHEAD_BYTES
            while self._bytes > BUDGET_BYTES and len(self._moments) > 1:
                self._thin_out()
            return True

    def _thin_out(self) -> None:
        """Drop every second moment, never the last: a replay that started from a dropped one finds a later one."""
        moments = self._moments[::-2][::-1]
        self.spacing *= 2
        for tile, versions in self._versions.items():
            # A tile unchanged at the next moment keeps its version; otherwise it has a version of that moment.
            self._versions[tile] = {moments[bisect_left(moments, moment)]: data for moment, data in versions.items()}
        self._moments = moments
        self._bytes = sum(len(data) + _OVERHEAD_BYTES for each in self._versions.values() for data in each.values())

    def restore(self, grid: OccupancyGrid, touched: NDArray[np.bool_], since: int, moment: int) -> CellBox | None:
        """Bring ``grid``, which was at the moment ``since`` and has been ``touched`` after it, to ``moment``.

        Return the box of the cells that may have changed, or None.
        """
        changed = touched.copy()
        with self._lock:
            low, high = sorted((since, moment))
            place = bisect_left(self._moments, high)  # changes up to a dropped moment belong to the next one
            high = self._moments[place] if place < len(self._moments) else high
            for tile, versions in self._versions.items():
                changed[tile] |= any(low < version <= high for version in versions)
            tiles = _listed(changed)
            copies = [self._version(tile, moment) for tile in tiles]
        cell_statistics.begin(grid, self.config.strategy)
        decompressor = zstandard.ZstdDecompressor()
        # Decompress everything before changing any cell, so that the grid is unchanged if memory runs out.
        unpacked = [None if data is None else decompressor.decompress(data) for data in copies]
        for tile, data in zip(tiles, unpacked, strict=True):
            if data is None:
                cell_statistics.forget(grid, self.config.strategy, _cells_of(tile))
            else:
                _fill(grid, _cells_of(tile), data)
        return _box_of(tiles, grid)

    def _version(self, tile: Tile, moment: int) -> bytes | None:
        """Return a tile's contents at a moment, None for its initial contents."""
        versions = self._versions.get(tile, {})
        newest = max((version for version in versions if version <= moment), default=None)
        return None if newest is None else versions[newest]


def _listed(touched: NDArray[np.bool_]) -> list[Tile]:
    return [(ty, tx) for ty, tx in np.argwhere(touched).tolist()]


def _cells_of(tile: Tile) -> Part:
    ty, tx = tile
    return np.s_[ty * TILE : (ty + 1) * TILE, tx * TILE : (tx + 1) * TILE]


def _box_of(tiles: list[Tile], grid: OccupancyGrid) -> CellBox | None:
    if not tiles:
        return None
    low, high = np.min(tiles, axis=0) * TILE, np.minimum((np.max(tiles, axis=0) + 1) * TILE, grid.geometry.shape)
    return CellBox(int(low[0]), int(high[0]), int(low[1]), int(high[1]))


def _packed(grid: OccupancyGrid, part: Part) -> bytes:
    """Return the packed contents of a grid for some cells."""
    arrays = [grid.log_odds[part], grid.observed[part]]
    return b"".join(
        array.tobytes()
        for array in (arrays if grid.cell_statistics is None else [*arrays, *grid.cell_statistics[:, *part]])
    )


def _fill(grid: OccupancyGrid, part: Part, data: bytes) -> None:
    """Restore the contents returned by :func:`_packed`."""
    arrays = [grid.log_odds[part], grid.observed[part]]
    at = 0
    for array in arrays if grid.cell_statistics is None else [*arrays, *grid.cell_statistics[:, *part]]:
        array[:] = np.frombuffer(data, array.dtype, array.size, at).reshape(array.shape)
        at += array.nbytes
