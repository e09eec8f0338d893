"""An occupancy grid: a floor and columns. Only changed tiles are sent again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import viser

from mapper.grid import GridGeometry
from server.scenes.drawer import Drawer, DrawerContext, yaw_wxyz
from server.scenes.map_mesh import MapLevels, changed_tiles, first_column, map_levels, tile_columns
from server.sessions.drawings import GridColumns, Point

COLUMN = (214, 112, 44)
FLOOR_Z = 0.01


@dataclass(frozen=True, slots=True)
class GridContent:
    """The levels of a grid and their position."""

    geometry: GridGeometry
    levels: MapLevels


class GridColumnsDrawer(Drawer[GridColumns, GridContent]):
    """One mesh for each tile of 64 × 64 cells, and one image for the floor."""

    reads_live_arrays: ClassVar[bool] = True
    max_hz: ClassVar[float] = 4.0

    def __init__(self, context: DrawerContext, drawing: GridColumns) -> None:
        super().__init__(context, drawing)
        self._floor: viser.ImageHandle | None = None
        self._tiles: dict[tuple[int, int], viser.MeshHandle] = {}
        self._shown: GridContent | None = None
        self._height = 1.0

    def set_height(self, height: float) -> None:
        """Draw the columns ``height`` times as high."""
        self._height = height
        for tile in self._tiles.values():
            tile.scale = (1.0, 1.0, height)

    def met(self, origin: Point, direction: Point) -> Point | None:
        """Return where a line of sight is in the first column that it meets; None if it meets none."""
        shown = self._shown
        if shown is None:
            return None
        x, y, yaw = shown.geometry.origin
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])  # rotation of the frame in the map
        start, along = np.array(origin, dtype=np.float64), np.array(direction, dtype=np.float64)
        local = np.append((start[:2] - (x, y)) @ turn, start[2]), np.append(along[:2] @ turn, along[2])
        place = first_column(shown.levels, self._height, *local)
        if place is None:
            return None
        px, py = (turn @ place[:2] + (x, y)).tolist()
        return (px, py, float(place[2]))

    @classmethod
    def read(cls, drawing: GridColumns) -> GridContent:
        """Compute heights and colours from the grid's values."""
        return GridContent(drawing.geometry, map_levels(drawing.geometry, drawing.log_odds, drawing.observed))

    def show(self, content: GridContent) -> None:
        """Draw the tiles and the floor that changed."""
        if self._shown is None or content.geometry != self._shown.geometry:
            self._start_again(content.geometry)
        old, self._shown = self._shown, content
        new, before = content.levels, None if old is None else old.levels
        if before is None or not np.array_equal(before.floor, new.floor):
            self._show_floor(new)
        for tile in changed_tiles(new.levels, before.levels if before else None):
            self._show_tile(new, tile)

    def _start_again(self, geometry: GridGeometry) -> None:
        for tile in self._tiles.values():
            tile.remove()
        self._tiles.clear()
        if self._floor is not None:
            self._floor.remove()
            self._floor = None
        self._shown = None
        x, y, yaw = geometry.origin
        self.frame.position = (x, y, 0.0)
        self.frame.wxyz = yaw_wxyz(yaw)

    def _show_floor(self, new: MapLevels) -> None:
        image = np.ascontiguousarray(GridGeometry.to_image(new.floor))
        if self._floor is not None:
            self._floor.image = image
            return
        width, height = new.size_m
        self._floor = self.scene.add_image(
            f"{self.path}/floor",
            image,
            width,
            height,
            format="png",
            cast_shadow=False,
            # Half a turn about x, because viser's images have their first row at the smallest y of their own frame.
            wxyz=(0.0, 1.0, 0.0, 0.0),
            position=(width / 2, height / 2, FLOOR_Z),
        )

    def _show_tile(self, new: MapLevels, tile: tuple[int, int]) -> None:
        vertices, faces = tile_columns(new.levels, tile, new.cell)
        if len(faces):
            self._tiles[tile] = self.scene.add_mesh_simple(
                f"{self.path}/{tile[0]}_{tile[1]}",
                vertices,
                faces,
                color=COLUMN,
                flat_shading=True,
                scale=(1.0, 1.0, self._height),
                cast_shadow=False,
            )
        elif tile in self._tiles:
            self._tiles.pop(tile).remove()
