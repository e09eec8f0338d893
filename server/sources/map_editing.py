"""The model of a session that shows a map and edits it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import ClassVar

import numpy as np
from msgspec import Struct

from mapper.core.array_types import Int8Array
from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.editing import EditedMap, Operation, parse_operation
from mapper.editing.areas import row_bands
from mapper.editing.files import map_files
from mapper.grid import TILE, CellBox, GridGeometry
from mapper.grid.kernels.quantise import NEVER_OBSERVED
from mapper.io.maps.reading import grid_of_values
from mapper.mapping.parameters import MappingConfig
from server.library.packs.reference_map import ReferenceMap
from server.sessions.hosting import ModelHost
from server.sessions.messages import NO_READINGS
from server.sessions.model import Footprint, SessionModel
from server.sessions.parts import EditedFiles
from server.sessions.tick import TickResult
from server.sessions.view import Playback
from server.stream.commands import MapEditCommand, MapHistoryCommand
from server.stream.layers import GridLayer, Layer
from server.stream.messages import FrameMessage, MapEditsMessage, ScanFields
from server.stream.protocol import fields_of
from server.stream.tiles import TilePicture, picture_range

MOST_CELLS = 1 << 24  #: of a map that is edited
MOST_LISTED = 12  #: of the last edits, in the message ``map_edits``
_FIELDS = {
    "paint": {"points": "points", "state": "state", "width": "width"},
    "fill": {"points": "polygon", "state": "state"},
    "keepout": {"points": "polygon", "value": "value"},
    "speed": {"points": "polygon", "value": "value"},
    "despeckle": {"value": "cells"},
    "rotate": {"angle": "angle"},
    "crop": {"points": "corners"},
    "origin": {"points": "points", "angle": "yaw"},
}  #: of each operation: the field of the command ``map_edit``, and its own

#: The picture's value (256,) of each value of a mask, by its bits: 1 … 127 as they are, else none.
_ZONE_SHADES = np.where((np.arange(256) > 0) & (np.arange(256) < 128), np.arange(256) - 127, NEVER_OBSERVED).astype(
    np.int8
)


def operation_of(command: MapEditCommand) -> Operation:
    """Return the operation of a command ``map_edit``. Raises :class:`mapper.core.errors.ConfigError`."""
    names = _FIELDS.get(command.op, {})
    given = {names[name]: value for name, value in fields_of(command).items() if name in names}
    places = given.pop("points", None) if command.op == "origin" else None
    if places:
        given |= {"x": places[0][0], "y": places[0][1]}
    return parse_operation({"op": command.op, **given})


class MapModel(SessionModel, EditedFiles):
    """A map of the library with its edits."""

    kind: ClassVar[str] = "map"

    def __init__(self, host: ModelHost, given: ReferenceMap, *, log_id: str) -> None:
        """Show a map. Raises :class:`LimitError` for one of more than :data:`MOST_CELLS` cells."""
        super().__init__(Playback(playing=False))
        self._host, self._given, self._log_id = host, given, log_id
        geometry = _limited(given.geometry, host.limits())
        self._edited = EditedMap(geometry, given.values, given.keepout, host.may_continue, speed=given.speed)
        self._map = GridLayer("map", "Map")
        self._keepout = GridLayer("keepout", "Keepout zones", "keepout")
        self._speed = GridLayer("speed_filter", "Speed limits", "speed")
        self._is_stale = True
        self._has_limits = False  #: whether the layer of speed limits was ever drawn
        self._draw()

    # -- what is shown --------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The map, its keepout zones and its speed limits."""
        return (self._map, self._keepout, self._speed)

    @property
    def title(self) -> str:
        """The name of the map."""
        return self._given.title

    @property
    def footprint(self) -> Footprint:
        """The cells of the states that are kept, and of the layers."""
        return Footprint(self._edited.cells + 6 * self._edited.values.size)

    @property
    def progress(self) -> tuple[int, int]:
        """The map is complete."""
        return (1, 1)

    def messages(self) -> list[Struct]:
        """Return the message ``map_edits``."""
        edited = self._edited
        return [
            MapEditsMessage(
                n=len(edited.operations),
                undone=edited.n_undone,
                last=[operation.phrase for operation in edited.operations[-MOST_LISTED:]],
                keepout_cells=int(np.count_nonzero(edited.keepout)),
                speed_cells=int(np.count_nonzero(edited.speed)),
                notes=list(self._given.notes),
            )
        ]

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the middle of the map as the pose: the cursor of the keyboard starts there."""
        geometry = self._edited.geometry
        x, y = geometry.cell_to_world(((geometry.rows - 1) // 2, (geometry.cols - 1) // 2)).round(4).tolist()
        frame.pose = (x, y, 0.0)

    def scan(self) -> ScanFields:
        """Return a scan without readings."""
        return NO_READINGS

    # -- editing --------------------------------------------------------------------------------------------------

    def advance(self, dt: float, result: TickResult) -> None:
        """Do nothing: a map stays as it is."""

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command: an edit, or a step through the edits."""
        edited = self._edited
        match command:
            case MapEditCommand():
                edited.apply(operation_of(command))
                is_other = True
            case MapHistoryCommand(steps=steps):
                is_other = edited.undo(-steps) if steps < 0 else steps > 0 and edited.redo(steps)
            case _:
                super().handle(command, result)
                return
        self._is_stale |= is_other
        result.changed |= is_other

    def draw(self, result: TickResult) -> None:
        """Show the map after the edits of this tick."""
        if self._is_stale:
            self._draw()
            result.slot(self.messages()[0])

    def _draw(self) -> None:
        self._is_stale = False
        edited = self._edited
        self._map.set_cells(edited.geometry, *picture_range(MappingConfig()), self._bands(edited.values, _map_shades()))
        self._keepout.set_cells(edited.geometry, 0.0, 254.0, self._bands(edited.keepout, _ZONE_SHADES))
        if self._has_limits or edited.speed.any():  # few maps have speed limits: the others are not drawn once more
            self._has_limits = True
            self._speed.set_cells(edited.geometry, 0.0, 254.0, self._bands(edited.speed, _ZONE_SHADES))

    def _bands(self, values: Int8Array, shades: Int8Array) -> Iterator[tuple[int, Int8Array]]:
        """Yield the first row and the picture's cells of bands of whole tiles; other sessions compute between them."""
        rows, cols = values.shape
        for row0, row1 in row_bands(rows, cols, multiple=TILE):
            self._host.may_continue()
            yield row0, shades[values[row0:row1].view(np.uint8)]

    # -- on the event loop ----------------------------------------------------------------------------------------

    async def files(self, stem: str) -> list[tuple[str, bytes]]:
        """Return the files of the present map, by name."""
        async with self._host.settled():
            return await self._host.on_thread(partial(_files, self._edited, stem, self.title))


def _files(edited: EditedMap, stem: str, source: str) -> list[tuple[str, bytes]]:
    return list(map_files(edited, stem, source))


@cache
def _map_shades() -> Int8Array:
    """Return the picture's value (256,) of each value of nav_msgs/OccupancyGrid, by its bits."""
    values = np.arange(-1, 101, dtype=np.int8)
    grid = grid_of_values(GridGeometry(1.0, 1, values.size), values[np.newaxis])
    picture = TilePicture(grid.geometry, *picture_range(MappingConfig()))
    picture.update(grid, CellBox(0, 1, 0, values.size))
    shades = np.full(256, NEVER_OBSERVED, dtype=np.int8)
    shades[values.view(np.uint8)] = picture.cells[0]
    return shades


def _limited(geometry: GridGeometry, limits: Limits) -> GridGeometry:
    """Return the geometry such that what edits make of it has a bounded number of cells."""
    most = min(MOST_CELLS, limits.max_cells // 8)
    if geometry.rows * geometry.cols > most:
        message = f"The map has {geometry.size_text} cells; here one of at most {most:,} cells can be edited."
        raise LimitError("edit.too_large", f"{message} The command gridbloom edit edits larger ones.")
    return replace(geometry, limits=replace(geometry.limits, max_cells=most))
