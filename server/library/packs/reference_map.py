"""A map of the library, or one in which a log is localized, and its file of arrays."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry
from server.library.packs.arrays import UNREADABLE, compressed_arrays

VERSION = 1


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceMap:
    """``values`` (rows, cols) int8 are those of nav_msgs/OccupancyGrid: 0 to 100, −1 unknown. ``title`` is for display.

    ``notes`` are those of its reader. ``keepout`` and ``speed`` (rows, cols) int8 are its masks of keepout zones and of
    speed limits, 0 to 100, None for none.
    """

    title: str
    geometry: GridGeometry
    values: NDArray[np.int8]
    notes: tuple[str, ...] = ()
    keepout: NDArray[np.int8] | None = None
    speed: NDArray[np.int8] | None = None

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its data for a file of arrays."""
        geometry = self.geometry
        about = {
            "version": VERSION,
            "title": self.title,
            "notes": self.notes,
            "resolution": geometry.resolution,
            "origin": list(geometry.origin),
        }
        masks = {"map_keepout": self.keepout, "map_speed": self.speed}
        text = np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)
        return {"map_about": text, "map_values": self.values, **{k: v for k, v in masks.items() if v is not None}}

    @classmethod
    def of_arrays(cls, arrays: Any) -> ReferenceMap:  # noqa: ANN401 - NumPy's archive has no type of its own
        """Return the map in a file of arrays. Raises :class:`ValueError` and :class:`KeyError`."""
        about, values = json.loads(arrays["map_about"].tobytes()), arrays["map_values"]
        if about["version"] != VERSION:
            raise ValueError(f"version {about['version']}")
        x, y, yaw = about["origin"]
        geometry = GridGeometry(
            float(about["resolution"]), values.shape[0], values.shape[1], (float(x), float(y), float(yaw))
        )
        masks = [arrays.get(name) for name in ("map_keepout", "map_speed")]
        for mask in masks:
            if mask is not None and mask.shape != values.shape:
                raise ValueError(f"mask of shape {mask.shape}")
        return cls(str(about["title"]), geometry, values, tuple(map(str, about["notes"])), *masks)

    def write(self, path: Path) -> None:
        """Write the map's file. Raises :class:`OSError`."""
        with atomic_write(path) as file:
            file.write(compressed_arrays(self.arrays()))

    def public(self) -> MapAnswer:
        """Return the answer of the HTTP interface."""
        return MapAnswer.of(self.title, self.geometry, self.notes)


@dataclass(frozen=True, slots=True)
class TerrainCounts:
    """Numbers of patches of each class."""

    safe: int
    unsafe: int
    unknown: int


@dataclass(frozen=True, slots=True)
class MapAnswer:
    """A map in the HTTP interface: ``resolution`` metres per cell, ``origin`` x, y (m) and yaw (rad).

    ``classes`` are the numbers of terrain patches of a cloud, null for other maps.
    """

    title: str
    rows: int
    cols: int
    resolution: float
    origin: tuple[float, float, float]
    notes: tuple[str, ...]
    classes: TerrainCounts | None = None

    @classmethod
    def of(
        cls,
        title: str,
        geometry: GridGeometry,
        notes: tuple[str, ...] = (),
        classes: TerrainCounts | None = None,
    ) -> MapAnswer:
        """Return the answer for a map with this geometry."""
        return cls(title, geometry.rows, geometry.cols, geometry.resolution, geometry.origin, notes, classes)


@dataclass(frozen=True, slots=True)
class ChosenMap:
    """The chosen map; null for none."""

    map: MapAnswer | None


def read_reference_map(path: Path) -> ReferenceMap:
    """Return the map in a file. Raises :class:`ConfigError` if there is none."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return ReferenceMap.of_arrays(arrays)
    except UNREADABLE:
        raise ConfigError("localization.no_map", "Choose a map to localize the log in first.") from None
