"""Writing of maps like nav2's map_saver: an image and the yaml that describes it.

Source: nav2_map_server, map_io.cpp. The modes:

``trinary``  a PGM of three greys: 0 occupied, 254 free, 205 unknown
``scale``    a PNG, grey (100 − v) % for a value v of 0 … 100, transparent if not observed
``raw``      a PGM with the value 0 … 100 as grey, 255 if not observed

The thresholds of the three states are p_occ 0.65 and 0.25. A trinary yaml nevertheless states 0.65 and 0.196, like
map_saver's: its reader interprets grey 205 as an occupancy of (255 − 205) / 255 = 0.196, so any higher ``free_thresh``
would turn unknown into free. A scale yaml states 1 and 0, between which the reader stretches the greys.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, GridGeometry, OccupancyGrid
from mapper.io.maps.images import pgm_pieces, png_pieces
from mapper.io.maps.pixels import PROBABILITY_PALETTE, probability_pixels, raw_pixels, scale_pixels, trinary_pixels
from mapper.sensors.georeference import NO_OFFSET, Offset

Mode = Literal["trinary", "scale", "raw"]

#: (occupied_thresh, free_thresh) stated by a yaml of each mode, so that reading restores what was written
STATED_THRESHOLDS: dict[Mode, tuple[float, float]] = {
    "trinary": (OCCUPIED_THRESHOLD, 0.196),
    "scale": (1.0, 0.0),
    "raw": (OCCUPIED_THRESHOLD, FREE_THRESHOLD),
}
FRAME_KEY = "gridbloom_frame"  #: in the yaml, which has no standard key for the map's frame
_PLAIN_NAME = re.compile(r"[A-Za-z][A-Za-z0-9._-]*\Z")


def pgm_bytes(
    grid: OccupancyGrid,
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
    mode: Mode = "trinary",
) -> bytes:
    """Return the map as a binary PGM, top row first, in mode ``trinary`` or ``raw``. Raises :class:`ConfigError`."""
    if mode not in ("trinary", "raw"):
        raise ConfigError(
            "map.mode", f"A PGM holds a trinary or a raw map, not mode {mode!r}, which needs transparency."
        )
    return b"".join(image_pieces(grid, occupied_threshold, free_threshold, mode))


def png_bytes(grid: OccupancyGrid) -> bytes:
    """Return a picture of p_occ: white is certainly free, black certainly occupied, pale blue never observed. Top row
    first.

    It is for viewing, not for reading back.
    """
    return b"".join(png_pieces(grid.geometry.shape, probability_pixels(grid), PROBABILITY_PALETTE))


def image_pieces(
    grid: OccupancyGrid,
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
    mode: Mode = "trinary",
) -> Iterator[bytes]:
    """Return the image of a map of ``mode`` in pieces, one band of rows at a time: a PGM, or a PNG in mode scale."""
    shape = grid.geometry.shape
    if mode == "trinary":
        return pgm_pieces(shape, trinary_pixels(grid, occupied_threshold, free_threshold))
    if mode == "raw":
        return pgm_pieces(shape, raw_pixels(grid, occupied_threshold, free_threshold))
    return png_pieces(shape, scale_pixels(grid, occupied_threshold, free_threshold))


def yaml_text(
    geometry: GridGeometry,
    image_name: str,
    mode: Mode = "trinary",
    *,
    occupied_thresh: float | None = None,
    free_thresh: float | None = None,
    frame: str | None = None,
    offset: Offset = NO_OFFSET,
) -> str:
    """Return the yaml of an image in its folder: resolution in m, origin as pose (x, y, yaw) of the lower-left corner.

    The thresholds are those for reading the image, not those it was made with, by default :data:`STATED_THRESHOLDS`.
    ``frame`` is the map's frame (None: not stated). It has a separate key, :data:`FRAME_KEY`; map_server and Nav2
    ignore unknown keys. ``offset`` (x, y) is added to the origin: that of the trajectory of a georeferenced log.
    """
    stated = STATED_THRESHOLDS[mode]
    occupied = stated[0] if occupied_thresh is None else occupied_thresh
    free = stated[1] if free_thresh is None else free_thresh
    x, y, yaw = geometry.origin
    origin = ", ".join(_number(value) for value in (x + offset[0], y + offset[1], yaw))
    stated_frame = "" if frame is None else f"{FRAME_KEY}: {_word(frame)}\n"
    return (
        f"image: {_word(image_name)}\nmode: {mode}\nresolution: {_number(geometry.resolution)}\norigin: [{origin}]\n"
        f"negate: 0\noccupied_thresh: {_number(occupied)}\nfree_thresh: {_number(free)}\n{stated_frame}"
    )


def _word(text: str) -> str:
    return text if _PLAIN_NAME.match(text) else _quoted(text)


def _quoted(text: str) -> str:
    """Return a word in quotes, with escapes for characters that YAML forbids or that break or reverse the line."""
    quoted = json.dumps(text, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in quoted)


def _number(value: float) -> str:
    """Return a number that every YAML version parses: in YAML 1.1 ``1e-05`` is a string, and ``1.0e-05`` a number."""
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")


def save_map(
    grid: OccupancyGrid,
    prefix: str | os.PathLike[str],
    mode: Mode = "trinary",
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
    frame: str | None = None,
    offset: Offset = NO_OFFSET,
) -> tuple[Path, Path]:
    """Write ``prefix.yaml`` and its image, ``prefix.pgm`` (``prefix.png`` in mode scale); return both paths.

    ``frame`` is the map's frame, if known, and ``offset`` that of its coordinates. Folders are created. Each file is
    written atomically, the image before the yaml. Raises :class:`ConfigError` if a file cannot be written.
    """
    base = Path(prefix)
    if not base.name:
        raise ConfigError("map.prefix", f"A map needs a file name, which {str(prefix)!r} lacks.")
    image_path = base.with_name(base.name + (".png" if mode == "scale" else ".pgm"))
    yaml_path = base.with_name(base.name + ".yaml")
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        for path, pieces in (
            (image_path, image_pieces(grid, occupied_threshold, free_threshold, mode)),
            (yaml_path, [yaml_text(grid.geometry, image_path.name, mode, frame=frame, offset=offset).encode()]),
        ):
            with atomic_write(path) as file:
                file.writelines(pieces)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError("map.unwritable", f"The map {base.name!r} cannot be written: {reason}.") from error
    return yaml_path, image_path
