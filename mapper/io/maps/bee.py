"""Maps of CMU's course on mobile robots (Wean Hall): a text of probabilities, plain or gzip.

Source: instruct.txt and wean.dat of the course's data. Lines ``robot_specifications->NAME VALUE`` (the size of the map,
the side of a cell and a shift, cm) are followed by ``global_map[0]: COLUMNS ROWS`` and then one row of numbers for each
x, with one number for each y: −1 is unknown, others are the probability that a cell is **free**. The instructions say
"occupied", but the scans of the course's logs are on the cells of 0.
"""

from __future__ import annotations

import gzip
import os
import re
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid import UNKNOWN, GridGeometry

MAGIC = b"robot_specifications"
GZIP_MAGIC = b"\x1f\x8b"
BYTES_PER_CELL = 16  #: maximum, of the text
_HEAD_BYTES = 4096

_SPECIFICATION = re.compile(rb"^robot_specifications->(\w+)[ \t]+([-+.\deE]+)[ \t\r]*$", re.MULTILINE)
_SIZE = re.compile(rb"^global_map\[0\]:[ \t]*(\d{1,7})[ \t]+(\d{1,7})[ \t\r]*\n", re.MULTILINE)


def is_bee_map(path: str | os.PathLike[str]) -> bool:
    """Return whether a file starts like these maps."""
    try:
        return _start(Path(path), len(MAGIC)) == MAGIC
    except (OSError, EOFError, ValueError, zlib.error):
        return False


def _start(path: Path, count: int) -> bytes:
    """Return the first ``count`` decompressed bytes of a file."""
    with path.open("rb") as file:
        if file.read(2) != GZIP_MAGIC:
            file.seek(0)
            return file.read(count)
    with gzip.open(path) as packed:
        return packed.read(count)


def read_bee_map(
    path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS
) -> tuple[GridGeometry, NDArray[np.int8]]:
    """Return the geometry of a map, and its cells (rows, cols) int8 as in nav_msgs: 0 … 100, −1 unknown.

    Raises :class:`ReadError` for a file that is damaged or incomplete, and :class:`LimitError` for one too large.
    """
    place = Path(path)
    try:
        head = _start(place, _HEAD_BYTES)
        size = _SIZE.search(head)
        if size is None:
            raise ReadError("map.bee_size", f"{place.name}: the map lacks the line 'global_map[0]: COLUMNS ROWS'.")
        cols, rows = int(size[1]), int(size[2])
        geometry = _geometry(head[: size.start()], cols, rows, limits, place.name)
        text = _start(place, size.end() + BYTES_PER_CELL * rows * cols + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise ReadError("map.bee", f"{place.name}: the map cannot be read: {error}.") from error
    if len(text) > size.end() + BYTES_PER_CELL * rows * cols:
        raise LimitError("map.bee_too_large", f"{place.name}: the text is longer than {cols} × {rows} cells need.")
    try:
        free = np.array(text[size.end() :].split(), dtype=np.float64)
    except ValueError as error:
        raise ReadError("map.bee_value", f"{place.name}: a cell of the map is not a number.") from error
    if len(free) != rows * cols:
        raise ReadError("map.bee_cells", f"{place.name}: the map has {len(free)} values for its {rows * cols} cells.")
    known = free >= 0.0
    if not ((free == -1.0) | (known & (free <= 1.0))).all():
        raise ReadError("map.bee_value", f"{place.name}: a cell of the map is neither -1 nor between 0 and 1.")
    values = np.where(known, np.rint(100.0 * (1.0 - free)), UNKNOWN).astype(np.int8)
    return geometry, np.ascontiguousarray(values.reshape(cols, rows).T)


def _geometry(head: bytes, cols: int, rows: int, limits: Limits, name: str) -> GridGeometry:
    try:
        specification = {key.decode(): float(value) for key, value in _SPECIFICATION.findall(head)}
    except ValueError as error:
        raise ReadError("map.bee_head", f"{name}: the map’s head has a value that is not a number.") from error
    resolution = specification.get("resolution", 0.0) / 100.0
    if not 0.0 < resolution < 100.0:
        raise ReadError("map.bee_head", f"{name}: the map’s head states no resolution.")
    x, y = (specification.get(key, 0.0) / 100.0 for key in ("autoshifted_x", "autoshifted_y"))
    return GridGeometry(resolution, rows, cols, (x, y, 0.0), limits)
