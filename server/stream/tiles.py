"""What of the map changed: the int8 picture of a grid, its tiles' revisions, and each tile compressed once.

The picture is written by the session's computation (:meth:`TilePicture.update`, on a worker thread) and read by the
event loop (:meth:`TilePicture.payload`). A tile that is compressed while it is written may mix two instants; it then
gets a new revision when the update is published, so whoever received the mixture receives the tile again.
"""

from __future__ import annotations

import numpy as np
import zstandard
from numpy.typing import NDArray

from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, TILE, GridGeometry, OccupancyGrid, log_odds
from mapper.grid.kernels.quantise import NEVER_OBSERVED, quantise
from mapper.mapping.integrate import CellBox
from mapper.mapping.parameters import BY_NAME, MappingConfig
from server.stream.protocol import TilePayload

ZSTD_LEVEL = 1
#: Log-odds below which a cell is free, and above which it is occupied.
STATE_BOUNDS = (float(log_odds(FREE_THRESHOLD)), float(log_odds(OCCUPIED_THRESHOLD)))


def picture_range(config: MappingConfig) -> tuple[float, float]:
    """Return the log-odds that −127 and 127 stand for: the clamp, or as far as it could be set where it is off."""
    if config.clamp:
        return (config.log_odds_min, config.log_odds_max)
    return (BY_NAME["log_odds_min"].low, BY_NAME["log_odds_max"].high)


class TilePicture:
    """The picture of one geometry: ``cells`` (rows, cols) int8, ``revision`` (tile rows, tile cols) uint32.

    Revision 0 is a tile in which nothing was ever observed. ``low`` … ``high`` are the log-odds of −127 … 127.
    """

    def __init__(self, geometry: GridGeometry, low: float, high: float, epoch: int, revision: int = 0) -> None:
        self.geometry = geometry
        self.low, self.high = low, high
        self.epoch = epoch
        self.newest = revision  #: the revision of the newest published update
        self.cells: NDArray[np.int8] = np.full(geometry.shape, NEVER_OBSERVED, dtype=np.int8)
        tiles = (-(-geometry.rows // TILE), -(-geometry.cols // TILE))
        self.revision: NDArray[np.uint32] = np.zeros(tiles, dtype=np.uint32)
        self._changed: NDArray[np.bool_] = np.zeros(tiles, dtype=np.bool_)
        self._payloads: dict[tuple[int, int], TilePayload] = {}
        self._compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL, write_content_size=True)

    def shows(self, geometry: GridGeometry, low: float, high: float) -> bool:
        """Whether the picture is of this geometry over this range of log-odds: if not, a new epoch has to begin."""
        return self.geometry == geometry and self.low == low and self.high == high

    def update(self, grid: OccupancyGrid, box: CellBox) -> int:
        """Bring a box of the picture up to date (worker thread); return how many cells changed."""
        return int(
            quantise(
                grid.log_odds, grid.observed, self.low, self.high, *STATE_BOUNDS,
                box.row0, box.row1, box.col0, box.col1, TILE, self.cells, self._changed,
            )
        )  # fmt: skip

    def publish(self) -> int:
        """Give what changed since the last call a new revision (event loop); return the number of tiles."""
        count = int(np.count_nonzero(self._changed))
        if count:
            self.newest += 1
            self.revision[self._changed] = self.newest
            self._changed[:] = False
        return count

    def payload(self, ty: int, tx: int) -> TilePayload:
        """Return a tile at its present revision, compressed: once for all who watch."""
        revision = int(self.revision[ty, tx])
        known = self._payloads.get((ty, tx))
        if known is not None and known.revision == revision:
            return known
        tile = self.cells[ty * TILE : (ty + 1) * TILE, tx * TILE : (tx + 1) * TILE]
        if tile.shape != (TILE, TILE):  # the last tiles of a grid that is not whole tiles
            whole = np.full((TILE, TILE), NEVER_OBSERVED, dtype=np.int8)
            whole[: tile.shape[0], : tile.shape[1]] = tile
            tile = whole
        payload = TilePayload(tx, ty, revision, self._compressor.compress(np.ascontiguousarray(tile).data))
        self._payloads[ty, tx] = payload
        return payload

    def message(self) -> dict[str, object]:
        """Return the ``geometry`` message."""
        return {
            "type": "geometry",
            "epoch": self.epoch,
            "resolution": self.geometry.resolution,
            "rows": self.geometry.rows,
            "cols": self.geometry.cols,
            "origin": list(self.geometry.origin),
            "log_odds_min": self.low,
            "log_odds_max": self.high,
            "tile": TILE,
        }


def picture_of(grid: OccupancyGrid, config: MappingConfig, epoch: int = 1, revision: int = 0) -> TilePicture:
    """Return a picture of the whole grid, not yet published."""
    picture = TilePicture(grid.geometry, *picture_range(config), epoch, revision)
    picture.update(grid, CellBox(0, grid.geometry.rows, 0, grid.geometry.cols))
    return picture


def update_picture(
    picture: TilePicture, grid: OccupancyGrid, config: MappingConfig, box: CellBox | None, *, whole: bool
) -> TilePicture | None:
    """Bring a picture up to date with its grid, ``whole`` or in a ``box``; return a new one where an epoch begins."""
    if not picture.shows(grid.geometry, *picture_range(config)):
        return picture_of(grid, config, picture.epoch + 1, picture.newest)
    if whole:
        picture.update(grid, CellBox(0, grid.geometry.rows, 0, grid.geometry.cols))
    elif box is not None:
        picture.update(grid, box)
    return None
