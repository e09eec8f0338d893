"""A grid as watchers see it: its picture in tiles, drawn on a worker thread and published on the event loop."""

from __future__ import annotations

from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import CellBox
from mapper.mapping.parameters import MappingConfig
from server.stream.tiles import TilePicture, picture_of, update_picture


class MapLayer:
    """One map of a session, by name."""

    def __init__(self, name: str, grid: OccupancyGrid, config: MappingConfig) -> None:
        self.name = name
        self.picture = picture_of(grid, config)
        self._next: TilePicture | None = None  #: of a new epoch, from the next publication on

    @property
    def epoch(self) -> int:
        """The epoch of the newest drawing."""
        return (self._next or self.picture).epoch

    def draw(self, grid: OccupancyGrid, config: MappingConfig, box: CellBox | None, *, whole: bool) -> bool:
        """Draw what changed, ``whole`` or in a ``box`` (worker thread); return whether a new epoch begins."""
        now = self._next or self.picture
        new = update_picture(now, grid, config, box, whole=whole)
        self._next = new or self._next
        return new is not None

    def begin_epoch(self, grid: OccupancyGrid, config: MappingConfig) -> None:
        """Draw another map, in a new epoch (worker thread)."""
        now = self._next or self.picture
        self._next = picture_of(grid, config, now.epoch + 1, now.newest)

    def take_epoch(self) -> TilePicture | None:
        """Return the picture of the epoch that begins now, None where none does (event loop)."""
        new, self._next = self._next, None
        self.picture = new or self.picture
        return new
