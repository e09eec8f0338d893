"""The layers that are grids: the int8 picture of a grid in tiles, recent changes of its cells, and clients' revisions.

The picture is written by the session's computation (:meth:`TilePicture.update`, on a worker thread) and read by the
event loop (:meth:`TilePicture.payloads`). Each tile is compressed once for all clients. A tile that is compressed while
it is written may contain parts of two updates; it then gets a new revision when the update is published, so clients
that received it receive it again.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import zstandard
from numpy.typing import NDArray

from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, TILE, CellBox, GridGeometry, OccupancyGrid, log_odds
from mapper.grid.kernels.lattice import to_lattice
from mapper.grid.kernels.quantise import NEVER_OBSERVED, quantise, quantise_cells, sort_by_tile
from mapper.mapping.parameters import BY_NAME, MappingConfig
from server.stream.layers import Body, Cursor, Layer, Point
from server.stream.messages import Geometry
from server.stream.protocol import CHANGES, TILES, CellChanges, TilePayload

MAX_BODIES = 8  #: maximum number of different bodies of a layer that are kept between two ticks
Lists = Sequence[NDArray[np.uint32]]

#: Level 1 with smaller tables, which are cheaper to clear, and matches of at least seven bytes, which are found faster.
#: For this amount of data, tiles are 2 % smaller and take less time than with the level's defaults.
ZSTD_PARAMETERS = zstandard.ZstdCompressionParameters(
    strategy=zstandard.STRATEGY_FAST, window_log=12, hash_log=9, min_match=7, write_content_size=True
)
#: Log-odds below which a cell is free, and above which it is occupied.
STATE_BOUNDS = (float(log_odds(FREE_THRESHOLD)), float(log_odds(OCCUPIED_THRESHOLD)))

#: Maximum number of changed cells kept, of the newest updates: 9 kB when sent.
MOST_CHANGES = 3072
MAX_FRAME_TILES = 2048
MOST_AT_ONCE = 32  #: maximum number of tiles compressed in one call
#: Start of each tile in one array, and its size, in the form that python-zstandard expects.
_SEGMENTS = np.array([(i * TILE * TILE, TILE * TILE) for i in range(MOST_AT_ONCE)], dtype=np.uint64).tobytes()

_EPOCHS = itertools.count(1)  # of the process; a new picture never reuses an epoch


_thread_state = threading.local()


def _compressor() -> zstandard.ZstdCompressor:
    """Return this thread's compressor. Sharing it among pictures keeps its tables in the processor's cache."""
    compressor: zstandard.ZstdCompressor | None = getattr(_thread_state, "compressor", None)
    if compressor is None:
        compressor = _thread_state.compressor = zstandard.ZstdCompressor(compression_params=ZSTD_PARAMETERS)
    return compressor


def picture_range(config: MappingConfig) -> tuple[float, float]:
    """Return the log-odds of −127 and 127: the clamping limits, or the widest possible ones if clamping is off."""
    if config.clamp:
        return (config.log_odds_min, config.log_odds_max)
    return (BY_NAME["log_odds_min"].low, BY_NAME["log_odds_max"].high)


class TilePicture:
    """The picture of one geometry: ``cells`` (rows, cols) int8, ``revision`` (tile rows, tile cols) uint32.

    ``revision`` is replaced, never modified. Revision 0: the tile has never had a value. ``low`` and ``high`` are the
    values of −127 and 127. ``epoch`` is greater than that of any earlier picture.
    """

    def __init__(self, geometry: GridGeometry, low: float, high: float, revision: int = 0) -> None:
        self.geometry = geometry
        self.low, self.high = low, high
        self.epoch = next(_EPOCHS)
        self.newest = revision  #: the revision of the newest published update
        self.cells: NDArray[np.int8] = np.full(geometry.shape, NEVER_OBSERVED, dtype=np.int8)
        tiles = (-(-geometry.rows // TILE), -(-geometry.cols // TILE))
        self.revision: NDArray[np.uint32] = np.zeros(tiles, dtype=np.uint32)
        self._changed: NDArray[np.bool_] = np.zeros(tiles, dtype=np.bool_)
        self._cells: NDArray[np.uint32] = np.empty(MOST_CHANGES, dtype=np.uint32)  # changed since publish()
        self._n_cells = 0  # number of changed cells, of which at most MOST_CHANGES are listed
        #: The newest published updates, the newest last: the previous ``revision``, and the changed cells.
        self._updates: list[tuple[NDArray[np.uint32], NDArray[np.uint32]]] = []
        self._payloads: dict[tuple[int, int], TilePayload] = {}

    def shows(self, geometry: GridGeometry, low: float, high: float) -> bool:
        """Return whether the picture has this geometry and range of values; if not, a new epoch must begin."""
        return self.geometry == geometry and self.low == low and self.high == high

    def update(self, grid: OccupancyGrid, box: CellBox) -> int:
        """Update a box of the picture from an occupancy grid (worker thread); return the number of changed cells."""
        listed = self._n_cells
        self._n_cells = quantise(
            grid.log_odds, grid.observed, self.low, self.high, *STATE_BOUNDS,
            box.row0, box.row1, box.col0, box.col1, TILE, self.cells, self._changed, self._cells, listed,
        )  # fmt: skip
        return self._n_cells - listed

    def update_cells(self, grid: OccupancyGrid, cells: NDArray[np.uint32]) -> int:
        """Update some ``cells`` (n,), ``row · cols + col``, like :meth:`update`."""
        listed = self._n_cells
        self._n_cells = quantise_cells(
            grid.log_odds, grid.observed, self.low, self.high, *STATE_BOUNDS,
            cells, TILE, self.cells, self._changed, self._cells, listed,
        )  # fmt: skip
        return self._n_cells - listed

    def set(
        self,
        values: NDArray[np.float32] | NDArray[np.uint8],
        missing: NDArray[np.bool_] | None = None,
        box: CellBox | None = None,
    ) -> None:
        """Set ``values`` (rows, cols), of which only those in ``box`` differ from the last ones (worker thread).

        Cells in ``missing`` or NaN have no value.
        """
        first_row = first_col = 0
        if box is not None:  # whole tiles
            first_row, first_col = box.row0 // TILE, box.col0 // TILE
            part = np.s_[first_row * TILE : -(-box.row1 // TILE) * TILE, first_col * TILE : -(-box.col1 // TILE) * TILE]
            values = values[part]
            missing = None if missing is None else missing[part]
        scaled = (values.astype(np.float32) - self.low) * np.float32(254.0 / (self.high - self.low)) - np.float32(127.0)
        none = np.isnan(scaled) if missing is None else np.isnan(scaled) | missing
        cells = np.where(none, NEVER_OBSERVED, np.clip(np.rint(scaled), -127, 127)).astype(np.int8)
        self._set_part(cells, first_row, first_col)

    def set_cells(self, cells: NDArray[np.int8], first_row: int = 0) -> None:
        """Set the ``cells`` (rows, cols) of the picture directly, from a row of tiles on (worker thread)."""
        self._set_part(cells, first_row, 0)

    def _set_part(self, cells: NDArray[np.int8], first_row: int, first_col: int) -> None:
        """Set the cells starting at a tile. ``cells`` ends at the end of a tile or of the picture."""
        top, left = first_row * TILE, first_col * TILE
        picture = self.cells[top : top + cells.shape[0], left : left + cells.shape[1]]
        rows, cols = -(-cells.shape[0] // TILE), -(-cells.shape[1] // TILE)
        differs = np.zeros((rows * TILE, cols * TILE), dtype=np.bool_)
        np.not_equal(cells, picture, out=differs[: cells.shape[0], : cells.shape[1]])
        changed = differs.reshape(rows, TILE, cols, TILE).any(axis=(1, 3))
        self._changed[first_row : first_row + rows, first_col : first_col + cols] |= changed
        picture[:] = cells
        self._n_cells = MOST_CHANGES + 1  # not listed

    def publish(self) -> int:
        """Assign a new revision to the tiles changed since the last call (event loop); return their number."""
        count = int(np.count_nonzero(self._changed))
        if count:
            self.newest += 1
            before, self.revision = self.revision, np.where(self._changed, np.uint32(self.newest), self.revision)
            self._changed.fill(False)
            self._keep_changes(before)
        self._n_cells = 0
        return count

    def _keep_changes(self, before: NDArray[np.uint32]) -> None:
        """Store the cells of the newest update, and of as many earlier ones as fit."""
        if self._n_cells > MOST_CHANGES:
            self._updates.clear()
            return
        self._updates.append((before, self._cells[: self._n_cells].copy()))
        total = sum(len(cells) for _, cells in self._updates)
        while total > MOST_CHANGES:
            total -= len(self._updates.pop(0)[1])

    def updates_since(self, revision: NDArray[np.uint32]) -> int:
        """Return the number of updates since ``revision`` (the same array) was current; 0 if they are not stored."""
        return next((len(self._updates) - i for i, (old, _) in enumerate(self._updates) if old is revision), 0)

    def changes(self, updates: int) -> CellChanges:
        """Return the cells changed by the last ``updates`` published updates (event loop).

        The values are the current ones; a cell written in the meantime is in the next update's changes again.
        """
        lists = [cells for _, cells in self._updates[-updates:]]
        cells = lists[0] if updates == 1 else np.concatenate(lists)
        tiles = np.zeros((min(len(cells), self.revision.size), 4), dtype=np.int16)
        places, values = np.empty(len(cells), dtype=np.uint16), np.empty(len(cells), dtype=np.int8)
        count = sort_by_tile(self.cells, cells, TILE, tiles, places, values)
        return CellChanges(self.newest, tiles[:count], places, values)

    def nearest_first(self, mask: NDArray[np.bool_], focus_xy: tuple[float, float]) -> NDArray[np.intp]:
        """Return tiles (n, 2), (ty, tx), of a ``mask``, nearest to ``focus_xy`` first, at most those of one frame."""
        rows, cols = mask.nonzero()
        tiles = np.empty((len(rows), 2), dtype=np.intp)
        tiles[:, 0], tiles[:, 1] = rows, cols
        if len(tiles) > 1:
            u, v = to_lattice(*focus_xy, self.geometry.frame)
            away = (rows - (v / TILE - 0.5)) ** 2 + (cols - (u / TILE - 0.5)) ** 2
            if len(tiles) > MAX_FRAME_TILES:
                nearest = np.argpartition(away, MAX_FRAME_TILES)[:MAX_FRAME_TILES]
                tiles, away = tiles[nearest], away[nearest]
            tiles = tiles[away.argsort(kind="stable")]
        return tiles

    def payloads(self, tiles: NDArray[np.intp]) -> Iterator[TilePayload]:
        """Yield ``tiles`` (n, 2), (ty, tx), at their current revisions. Each is compressed once for all clients."""
        payloads = self._payloads
        for first in range(0, len(tiles), MOST_AT_ONCE):
            some = tiles[first : first + MOST_AT_ONCE]
            revisions = self.revision[some[:, 0], some[:, 1]].tolist()
            places = some.tolist()
            cached = [payloads.get((ty, tx)) for ty, tx in places]
            old = [i for i, tile in enumerate(cached) if tile is None or tile.revision != revisions[i]]
            for i, data in zip(old, self._compressed(some[old]), strict=True):
                ty, tx = places[i]
                cached[i] = payloads[ty, tx] = TilePayload(tx, ty, revisions[i], data)
            yield from (tile for tile in cached if tile is not None)

    def _compressed(self, tiles: NDArray[np.intp]) -> list[bytes]:
        """Return ``tiles`` (n, 2), (ty, tx), compressed one by one."""
        if len(tiles) == 0:
            return []
        cells = np.full((len(tiles), TILE, TILE), NEVER_OBSERVED, dtype=np.int8)
        for out, (ty, tx) in zip(cells, tiles.tolist(), strict=True):
            tile = self.cells[ty * TILE : (ty + 1) * TILE, tx * TILE : (tx + 1) * TILE]
            out[: tile.shape[0], : tile.shape[1]] = tile  # the last tiles of a grid may extend beyond it
        # All in one call, because each call releases the interpreter's lock and has to wait for it again.
        parts = zstandard.BufferWithSegments(cells.data, _SEGMENTS[: 16 * len(tiles)])
        packed = _compressor().multi_compress_to_buffer(parts)
        return [packed[i].tobytes() for i in range(len(tiles))]

    def message(self, layer: int) -> Geometry:
        """Return the ``geometry`` message of the layer with this id."""
        return Geometry(
            layer=layer,
            epoch=self.epoch,
            resolution=self.geometry.resolution,
            rows=self.geometry.rows,
            cols=self.geometry.cols,
            origin=self.geometry.origin,
            low=self.low,
            high=self.high,
            tile=TILE,
        )


class GridLayer(Layer):
    """A grid: an occupancy grid, set with :meth:`update`, or values on a linear scale, set with :meth:`set`."""

    kind = "grid"

    def __init__(self, name: str, title: str, style: str = "belief") -> None:
        super().__init__(name, title, style)
        self.picture: TilePicture | None = None  #: the published picture; None before the first
        self._written: TilePicture | None = None  # the picture being written, which may begin a new epoch
        #: By what a client had and how much it accepts: the body to send, and what it has then. Most clients that
        #: follow a session share these.
        self.bodies: dict[tuple[object, ...], tuple[Body | None, NDArray[np.uint32]]] = {}
        self._changes: dict[int, Body] = {}  # by the number of updates

    @property
    def epoch(self) -> int:
        """The epoch of the newest picture, published or not; 0 if there is none."""
        return 0 if self._written is None else self._written.epoch

    def update(
        self,
        grid: OccupancyGrid,
        config: MappingConfig,
        box: CellBox | None,
        *,
        whole: bool,
        cells: Lists | None = None,
    ) -> bool:
        """Update the picture from an occupancy grid, ``whole`` or in a ``box`` (worker thread).

        ``cells``, arrays of ``row · cols + col``, restricts it to these cells of the box. Returns whether a new epoch
        begins.
        """
        picture, is_new = self._picture_of(grid.geometry, *picture_range(config))
        if whole or is_new:
            box, cells = CellBox(0, grid.geometry.rows, 0, grid.geometry.cols), None
        if box is not None and cells is None:
            picture.update(grid, box)
        for some in cells or ():
            picture.update_cells(grid, some)
        return is_new

    def set(
        self,
        geometry: GridGeometry,
        values: NDArray[np.float32] | NDArray[np.uint8],
        low: float,
        high: float,
        missing: NDArray[np.bool_] | None = None,
        box: CellBox | None = None,
    ) -> bool:
        """Set ``values`` (rows, cols), clipped to ``low`` … ``high`` (worker thread).

        Only cells in ``box`` (None: all) are read unless the picture is a new one. A cell that is ``missing`` (rows,
        cols) or NaN has no value. Returns whether a new epoch begins. Raises :class:`ValueError` for another shape than
        the geometry's, or unless ``low < high``.
        """
        if values.shape != geometry.shape or not low < high:
            raise ValueError(f"values of shape {values.shape}, {low} … {high}, do not fit a grid {geometry.shape}")
        picture, is_new = self._picture_of(geometry, low, high)
        picture.set(values, missing, None if is_new else box)
        return is_new

    def set_bytes(self, geometry: GridGeometry, values: NDArray[np.uint8]) -> bool:
        """Set ``values`` (rows, cols), 0 to 254, 255 for none; like :meth:`set`, without rounding (worker thread)."""
        if values.shape != geometry.shape or values.dtype != np.uint8:
            raise ValueError(f"values of shape {values.shape} {values.dtype} do not fit a grid {geometry.shape}")
        # 255 becomes -128, which means no value.
        return self.set_cells(geometry, 0.0, 254.0, [(0, (values - np.uint8(127)).view(np.int8))])

    def set_cells(
        self, geometry: GridGeometry, low: float, high: float, bands: Iterable[tuple[int, NDArray[np.int8]]]
    ) -> bool:
        """Set the cells of the picture directly; −127 and 127 are ``low`` and ``high`` (worker thread).

        ``bands`` are the first row and the cells (rows, cols) of bands of whole tiles; −128 means no value. Returns
        whether a new epoch begins.
        """
        picture, is_new = self._picture_of(geometry, low, high)
        for row0, cells in bands:
            picture.set_cells(cells, row0 // TILE)
        return is_new

    def _picture_of(self, geometry: GridGeometry, low: float, high: float) -> tuple[TilePicture, bool]:
        """Return the picture of this geometry and range for writing, and whether it is a new one."""
        before = self._written
        if before is not None and before.shows(geometry, low, high):
            return before, False
        self._written = TilePicture(geometry, low, high, 0 if before is None else before.newest)
        return self._written, True

    def publish(self) -> None:
        """Publish the newest picture. Its changes get a new revision."""
        self.picture = self._written
        if self.picture is not None:
            self.picture.publish()
        self.bodies.clear()
        self._changes.clear()

    def changes(self, picture: TilePicture, updates: int) -> Body:
        """Return a body with the cells changed by the last ``updates`` updates of the published ``picture``."""
        body = self._changes.get(updates)
        if body is None:
            count, parts = CHANGES.encode(picture.changes(updates))
            body = self._changes[updates] = Body(CHANGES.kind, picture.epoch, count, parts, tiles=count)
        return body

    def cursor(self) -> GridCursor:
        """Return the cursor of a client without tiles."""
        return GridCursor(self)


class GridCursor(Cursor):
    """Records the revision of each tile that was sent to a client."""

    def __init__(self, layer: GridLayer) -> None:
        self._layer = layer
        self._picture: TilePicture | None = None
        self._announced: TilePicture | None = None
        self._has: NDArray[np.uint32] = np.zeros((0, 0), dtype=np.uint32)  # never written, because cursors share it

    def _follow(self) -> TilePicture | None:
        """Return the layer's picture; clear the record if the picture is new."""
        picture = self._layer.picture
        if picture is not self._picture and picture is not None:
            self._picture = picture
            self._has = np.zeros_like(picture.revision)
        return picture

    def is_behind(self) -> bool:
        """Return whether there are tiles to send."""
        picture = self._follow()
        if picture is None or self._has is picture.revision:
            return False
        if picture.updates_since(self._has) or (picture.revision != self._has).any():
            return True
        self._has = picture.revision
        return False

    def dirty_tiles(self) -> int:
        """Return the number of tiles to send to the client."""
        picture = self._follow()
        return 0 if picture is None else int(np.count_nonzero(picture.revision != self._has))

    def announcement(self, layer: int) -> Geometry | None:
        """Return the ``geometry`` message of a new epoch."""
        picture = self._layer.picture
        if picture is None or picture is self._announced:
            return None
        self._announced = picture
        return picture.message(layer)

    def resume(self, epoch: int, revision: int) -> None:
        """Record that the client still has all tiles of ``epoch`` up to ``revision``."""
        picture = self._follow()
        if picture is not None and epoch == picture.epoch:
            self._has = np.where(picture.revision <= revision, picture.revision, self._has)

    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:  # noqa: ARG002 - divided
        """Return the changes of the newest updates, if the client has all earlier ones and they fit in ``share`` bytes.

        Otherwise return tiles of about ``share`` bytes, those nearest to ``focus_xy`` first.
        """
        picture = self._follow()
        if picture is None:
            return None
        updates = picture.updates_since(self._has)
        if updates:
            changes = self._layer.changes(picture, updates)
            if sum(map(len, changes.parts)) <= share:
                self._has = picture.revision
                return changes
        bodies = self._layer.bodies
        key = (picture.epoch, self._has.tobytes(), share, focus_xy, always)
        if key not in bodies:
            body, has = _next_tiles(picture, self._has, share, focus_xy, always=always)
            if len(bodies) >= MAX_BODIES:
                self._has = has
                return body
            bodies[key] = (body, has)
        body, self._has = bodies[key]
        return body

    def empty(self) -> Body | None:
        """Return a frame's body without tiles."""
        picture = self._follow()
        return None if picture is None else Body(TILES.kind, picture.epoch, 0, (), not self.is_behind())


def _next_tiles(
    picture: TilePicture, has: NDArray[np.uint32], share: int, focus_xy: Point, *, always: bool
) -> tuple[Body | None, NDArray[np.uint32]]:
    """Return the next tiles for a client with the revisions ``has``, and its revisions after them.

    The arguments are those of :meth:`Cursor.take`.
    """
    order = picture.nearest_first(picture.revision != has, focus_xy)
    tiles: list[TilePayload] = []
    size = 0
    for tile in picture.payloads(order):
        size += len(tile.data)
        if size > share and (tiles or not always):
            break
        tiles.append(tile)
    if not tiles:
        return None, has
    has = has.copy()
    ty, tx = order[: len(tiles)].T
    has[ty, tx] = [tile.revision for tile in tiles]
    complete = not (picture.revision != has).any()
    count, parts = TILES.encode(tiles)
    return Body(TILES.kind, picture.epoch, count, parts, complete, count), picture.revision if complete else has
