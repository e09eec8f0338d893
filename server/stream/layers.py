"""The layers of a session: written by the computation, published by the event loop, read by clients.

A layer is written on a worker thread. Its changes take effect with :meth:`Layer.publish`, which the hub calls on the
event loop while the worker does not run. Content is encoded once for all clients; a :class:`Cursor` records what one
client has of a layer.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mapper.grid import TILE, CellBox, GridGeometry, OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from server.stream.codecs import CHANGES, CODECS, TILES, TilePayload
from server.stream.message_parts import LayerInfo
from server.stream.messages import Geometry
from server.stream.tiles import TilePicture, picture_range

MAX_BODIES = 8  #: different bodies of a layer that are kept between two ticks

Point = tuple[float, float]
Lists = Sequence[NDArray[np.uint32]]


@dataclass(frozen=True, slots=True)
class Body:
    """The encoded body of a frame, with the fields of its header; ``tiles`` is the number of tiles in it."""

    kind: int
    epoch: int
    count: int
    parts: Sequence[bytes]
    complete: bool = True
    tiles: int = 0


class Cursor(ABC):
    """Records what one client has of a layer (event loop)."""

    batch = 0  #: number of the client's last batch that contained the layer

    @abstractmethod
    def is_behind(self) -> bool:
        """Whether the client has not yet been sent the newest content."""

    @abstractmethod
    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:
        """Return the next body, and mark it as sent.

        A layer that can be divided gives about ``share`` bytes; another at most ``room`` bytes, else None, unless
        ``always``. Tiles nearest to ``focus_xy``, map metres, are sent first.
        """

    def announcement(self, layer: int) -> Geometry | None:  # noqa: ARG002 - most have none
        """Return the message that has to be sent once before the next frame of the layer with the id ``layer``."""
        return None

    def resume(self, epoch: int, revision: int) -> None:  # noqa: B027 - nothing to do for content that is always sent whole
        """Note that the client still has ``epoch`` up to ``revision`` from an earlier connection."""

    def empty(self) -> Body | None:
        """Return a body without content; None if the codec has none."""
        return None

    def dirty_tiles(self) -> int:
        """Return the number of tiles that have to be sent to the client."""
        return 0


class Layer(ABC):
    """A named layer. ``style`` names the palette or overlay with which pages paint it.

    ``columns`` are the names of the columns of its table: ``x``, ``y`` (map metres) and more, such as ``yaw``
    (radians), ``value`` or ``stamp`` (seconds).
    """

    kind: Literal["grid", "points", "path", "graph"]

    def __init__(self, name: str, title: str, style: str, columns: Sequence[str] = ()) -> None:
        self.name = name
        self.title = title
        self.style = style
        self.columns = tuple(columns)
        self.codec = CODECS[self.kind]
        self.is_watched = False  #: whether a client is sent the layer (set on the event loop)
        self.is_on_demand = False  #: whether it is written only while it is watched

    def info(self, layer: int) -> LayerInfo:
        """Return the entry of the message ``layers`` for the layer, whose id is ``layer``."""
        return LayerInfo(layer, self.name, self.kind, self.title, self.style, list(self.columns))

    @abstractmethod
    def publish(self) -> None:
        """Publish the changes since the last call (event loop)."""

    @abstractmethod
    def cursor(self) -> Cursor:
        """Return the cursor of a client that has nothing (event loop)."""


class GridLayer(Layer):
    """A grid: an occupancy grid, set with :meth:`update`, or values on a linear scale, set with :meth:`set`."""

    kind = "grid"

    def __init__(self, name: str, title: str, style: str = "belief") -> None:
        super().__init__(name, title, style)
        self.picture: TilePicture | None = None  #: the published one; None before the first
        self._written: TilePicture | None = None  # the picture that is written, which may begin a new epoch
        #: By what a client had and how much it takes: the body that it is sent, and what it has then. Of the clients
        #: that follow a session most have the same.
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

        With ``cells``, arrays of ``row · cols + col``, only these of the box. Return whether a new epoch begins.
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

        Only cells in ``box`` are looked at unless the picture is a new one; without it all are. A cell that is
        ``missing`` (rows, cols) or NaN has no value. Return whether a new epoch begins. Raises :class:`ValueError` for
        another shape than the geometry's, or unless ``low < high``.
        """
        if values.shape != geometry.shape or not low < high:
            raise ValueError(f"values of shape {values.shape}, {low} … {high}, do not fit a grid {geometry.shape}")
        picture, is_new = self._picture_of(geometry, low, high)
        picture.set(values, missing, None if is_new else box)
        return is_new

    def set_bytes(self, geometry: GridGeometry, values: NDArray[np.uint8]) -> bool:
        """Set ``values`` (rows, cols) from 0 to 254, 255 for none; as :meth:`set`, without rounding (worker thread)."""
        if values.shape != geometry.shape or values.dtype != np.uint8:
            raise ValueError(f"values of shape {values.shape} {values.dtype} do not fit a grid {geometry.shape}")
        # 255 becomes -128, which is no value.
        return self.set_cells(geometry, 0.0, 254.0, [(0, (values - np.uint8(127)).view(np.int8))])

    def set_cells(
        self, geometry: GridGeometry, low: float, high: float, bands: Iterable[tuple[int, NDArray[np.int8]]]
    ) -> bool:
        """Set the cells of the picture themselves, in which −127 … 127 are ``low`` … ``high`` (worker thread).

        ``bands`` are the first row and the cells (rows, cols) of bands of whole tiles; −128 is no value. Return whether
        a new epoch begins.
        """
        picture, is_new = self._picture_of(geometry, low, high)
        for row0, cells in bands:
            picture.set_cells(cells, row0 // TILE)
        return is_new

    def _picture_of(self, geometry: GridGeometry, low: float, high: float) -> tuple[TilePicture, bool]:
        """Return the picture of this geometry and range to write, and whether it is a new one."""
        before = self._written
        if before is not None and before.shows(geometry, low, high):
            return before, False
        self._written = TilePicture(geometry, low, high, 0 if before is None else before.newest)
        return self._written, True

    def publish(self) -> None:
        """Publish the newest picture; its changes get a new revision."""
        self.picture = self._written
        if self.picture is not None:
            self.picture.publish()
        self.bodies.clear()
        self._changes.clear()

    def changes(self, picture: TilePicture, updates: int) -> Body:
        """Return a body with the cells that so many of the newest updates of the published ``picture`` changed."""
        body = self._changes.get(updates)
        if body is None:
            count, parts = CHANGES.encode(picture.changes(updates))
            body = self._changes[updates] = Body(CHANGES.kind, picture.epoch, count, parts, tiles=count)
        return body

    def cursor(self) -> GridCursor:
        """Return the cursor of a client that has no tile."""
        return GridCursor(self)


class GridCursor(Cursor):
    """Records the revision of each tile that a client was sent."""

    def __init__(self, layer: GridLayer) -> None:
        self._layer = layer
        self._picture: TilePicture | None = None
        self._announced: TilePicture | None = None
        self._has: NDArray[np.uint32] = np.zeros((0, 0), dtype=np.uint32)  # never written: cursors share it

    def _follow(self) -> TilePicture | None:
        """Return the layer's picture; for a new picture, clear the record."""
        picture = self._layer.picture
        if picture is not self._picture and picture is not None:
            self._picture = picture
            self._has = np.zeros_like(picture.revision)
        return picture

    def is_behind(self) -> bool:
        """Whether tiles have to be sent."""
        picture = self._follow()
        if picture is None or self._has is picture.revision:
            return False
        if picture.updates_since(self._has) or (picture.revision != self._has).any():
            return True
        self._has = picture.revision
        return False

    def dirty_tiles(self) -> int:
        """Return the number of tiles that have to be sent to the client."""
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
        """Note that the client still has all tiles of ``epoch`` up to ``revision``."""
        picture = self._follow()
        if picture is not None and epoch == picture.epoch:
            self._has = np.where(picture.revision <= revision, picture.revision, self._has)

    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:  # noqa: ARG002 - divided
        """Return the changes of the newest updates, if the client has all before them and ``share`` bytes hold them.

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
    """Return the next tiles of a client with the revisions ``has``, as :meth:`Cursor.take`, and what it has then."""
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
