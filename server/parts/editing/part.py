"""The edits of a map: displaying, applying and undoing them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

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
from server.parts.editing.messages import MapEditCommand, MapEditsMessage, MapHistoryCommand
from server.sessions.hosting import ModelHost
from server.sessions.part import Offers, Part
from server.sessions.parts import EditedFiles
from server.sessions.tick import TickResult
from server.stream.grid_layer import GridLayer, TilePicture, picture_range
from server.stream.protocol import fields_of

MOST_CELLS = 1 << 24  #: maximum for an edited map
MOST_LISTED = 12  #: number of the last edits in the message ``map_edits``
_FIELDS = {
    "paint": {"points": "points", "state": "state", "width": "width"},
    "fill": {"points": "polygon", "state": "state"},
    "keepout": {"points": "polygon", "value": "value"},
    "speed": {"points": "polygon", "value": "value"},
    "despeckle": {"value": "cells"},
    "rotate": {"angle": "angle"},
    "crop": {"points": "corners"},
    "origin": {"points": "points", "angle": "yaw"},
}  #: for each operation: the field of the ``map_edit`` command, and the operation's own

#: Picture value (256,) for each value of a mask, by its bits: 1 to 127 unchanged, otherwise none.
_ZONE_SHADES = np.where((np.arange(256) > 0) & (np.arange(256) < 128), np.arange(256) - 127, NEVER_OBSERVED).astype(
    np.int8
)


def operation_of(command: MapEditCommand) -> Operation:
    """Return the operation of a ``map_edit`` command. Raises :class:`mapper.core.errors.ConfigError`."""
    names = _FIELDS.get(command.op, {})
    values = {names[name]: value for name, value in fields_of(command).items() if name in names}
    places = values.pop("points", None) if command.op == "origin" else None
    if places:
        values |= {"x": places[0][0], "y": places[0][1]}
    return parse_operation({"op": command.op, **values})


class Editing(Part, EditedFiles):
    """A map with its edits, its keepout zones and its speed limits."""

    commands = (MapEditCommand, MapHistoryCommand)

    def __init__(self, host: ModelHost, reference: ReferenceMap) -> None:
        """Show a map. Raises :class:`LimitError` if it has more than :data:`MOST_CELLS` cells."""
        self._host, self._given = host, reference
        geometry = _limited(reference.geometry, host.limits())
        self._edited = EditedMap(
            geometry, reference.values, reference.keepout, host.may_continue, speed=reference.speed
        )
        self._map = GridLayer("map", "Map")
        self._keepout = GridLayer("keepout", "Keepout zones", "keepout")
        self._speed = GridLayer("speed_filter", "Speed limits", "speed")
        self._is_stale = True
        self._has_limits = False  #: whether the layer of speed limits was ever drawn
        self._draw()

    @property
    def geometry(self) -> GridGeometry:
        """The geometry of the current map."""
        return self._edited.geometry

    @property
    def layers(self) -> tuple[GridLayer, ...]:
        """The map, its keepout zones and its speed limits."""
        return (self._map, self._keepout, self._speed)

    @property
    def cells(self) -> int:
        """Number of cells of the stored states and of the layers."""
        return self._edited.cells + 6 * self._edited.values.size

    def messages(self) -> list[MapEditsMessage]:
        """Return the ``map_edits`` message."""
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

    def handle(self, command: MapEditCommand | MapHistoryCommand, result: TickResult) -> None:
        """Carry out an edit, or undo or redo edits."""
        edited = self._edited
        match command:
            case MapEditCommand():
                edited.apply(operation_of(command))
                is_other = True
            case MapHistoryCommand(steps=steps):
                is_other = edited.undo(-steps) if steps < 0 else steps > 0 and edited.redo(steps)
        self._is_stale |= is_other
        result.changed |= is_other

    def changed(self, result: TickResult) -> None:
        """Show the map after the edits of this tick."""
        if self._is_stale:
            self._draw()
            result.slot(self.messages()[0])

    def _draw(self) -> None:
        self._is_stale = False
        edited = self._edited
        self._map.set_cells(edited.geometry, *picture_range(MappingConfig()), self._bands(edited.values, _map_shades()))
        self._keepout.set_cells(edited.geometry, 0.0, 254.0, self._bands(edited.keepout, _ZONE_SHADES))
        if self._has_limits or edited.speed.any():  # few maps have speed limits, and an unused layer is not redrawn
            self._has_limits = True
            self._speed.set_cells(edited.geometry, 0.0, 254.0, self._bands(edited.speed, _ZONE_SHADES))

    def _bands(self, values: Int8Array, shades: Int8Array) -> Iterator[tuple[int, Int8Array]]:
        """Yield the first row and the picture's cells of bands of whole tiles; other sessions compute in between."""
        rows, cols = values.shape
        for row0, row1 in row_bands(rows, cols, multiple=TILE):
            self._host.may_continue()
            yield row0, shades[values[row0:row1].view(np.uint8)]

    # -- on the event loop ----------------------------------------------------------------------------------------

    async def files(self, stem: str) -> list[tuple[str, bytes]]:
        """Return the files of the current map, by name."""
        async with self._host.settled():
            return await self._host.on_thread(partial(_files, self._edited, stem, self._given.title))


def part_of(offers: Offers) -> Editing | None:
    """Return the part of a map."""
    return None if offers.map is None else Editing(offers.host, offers.map)


def _files(edited: EditedMap, stem: str, source: str) -> list[tuple[str, bytes]]:
    return list(map_files(edited, stem, source))


@cache
def _map_shades() -> Int8Array:
    """Return the picture value (256,) for each value of nav_msgs/OccupancyGrid, by its bits."""
    values = np.arange(-1, 101, dtype=np.int8)
    grid = grid_of_values(GridGeometry(1.0, 1, values.size), values[np.newaxis])
    picture = TilePicture(grid.geometry, *picture_range(MappingConfig()))
    picture.update(grid, CellBox(0, 1, 0, values.size))
    shades = np.full(256, NEVER_OBSERVED, dtype=np.int8)
    shades[values.view(np.uint8)] = picture.cells[0]
    return shades


def _limited(geometry: GridGeometry, limits: Limits) -> GridGeometry:
    """Return the geometry with limits that bound the number of cells after edits."""
    most = min(MOST_CELLS, limits.max_cells // 8)
    if geometry.rows * geometry.cols > most:
        message = f"The map has {geometry.size_text} cells; here one of at most {most:,} cells can be edited."
        raise LimitError("edit.too_large", f"{message} The command gridbloom edit edits larger ones.")
    return replace(geometry, limits=replace(geometry.limits, max_cells=most))
