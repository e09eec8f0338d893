"""Reading of maps like nav2's map_server.

Source: nav2_map_server, map_io.cpp. The occupancy of a pixel with shade s, 0 … 1, is o = 1 − s, or s with ``negate`` in
the yaml; a cell's value is

``trinary``  100 where o > occupied_thresh, 0 where o < free_thresh, else −1; an alpha channel counts as a fourth colour
``scale``    −1 where not opaque, else 100 and 0 by the same thresholds, and between them stretched over 0 … 100
``raw``      the grey 0 … 255 itself where it is at most 100, else −1
"""

from __future__ import annotations

import io
import math
import os
import re
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import BmpImagePlugin, Image, ImageFile, PngImagePlugin, PpmImagePlugin

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import wrap_angle
from mapper.grid import (
    FREE,
    FREE_THRESHOLD,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    UNKNOWN,
    GridGeometry,
    OccupancyGrid,
    log_odds,
)
from mapper.io.maps.bee import is_bee_map, read_bee_map
from mapper.io.maps.description import MapDescription, image_path, parse_description
from mapper.io.maps.pixels import GREY_FREE, GREY_OCCUPIED, GREY_UNKNOWN

MOST_HEADER_BYTES = 1 << 17  #: including comments, because Pillow reads a header byte by byte
PLAIN = (b"P1", b"P2", b"P3")
_NETPBM = (*PLAIN, b"P4", b"P5", b"P6")
_BLOCK = 1 << 20
_COMMENT = re.compile(rb"#[^\r\n]*[\r\n]?")


def open_plain_image(file: BinaryIO, named: str) -> PpmImagePlugin.PpmImageFile:
    """Open the PGM, PBM or PPM image in ``file``; ``named`` is the beginning of error messages. Source: netpbm's
    pgm(5).

    Pillow's reader gets a header of limited length, and plain files without comments. Raises :class:`LimitError` for a
    header longer than :data:`MOST_HEADER_BYTES`, and Pillow's errors.
    """
    head = file.read(MOST_HEADER_BYTES)
    file.seek(0)
    header = io.BytesIO(head)
    try:
        PpmImagePlugin.PpmImageFile(header)
    except ValueError:
        if header.tell() < MOST_HEADER_BYTES:
            raise
        raise LimitError(
            "map.image_header", f"{named} has a header of more than {MOST_HEADER_BYTES} bytes, comments included."
        ) from None
    is_plain = head.startswith(PLAIN)
    image = PpmImagePlugin.PpmImageFile(_WithoutComments(file) if is_plain else file)  # type: ignore[arg-type]
    if not is_plain:
        (tile,) = image.tile
        if (
            head[tile.offset - 1 : tile.offset + 1] == b"\r\n"
            and _bytes_of(image, head) == _size(file) - tile.offset - 1
        ):
            image.tile = [tile._replace(offset=tile.offset + 1)]  # Windows line ends
    return image


def _size(file: BinaryIO) -> int:
    at = file.tell()
    size = file.seek(0, io.SEEK_END)
    file.seek(at)
    return size


def _bytes_of(image: PpmImagePlugin.PpmImageFile, head: bytes) -> int:
    """Return the size in bytes of the pixels of an image in a binary format."""
    width, height = image.size
    if head.startswith(b"P4"):
        return (width + 7) // 8 * height
    args: Any = image.tile[0].args  # (mode, maximum value) if pixels are scaled, else a mode
    wide = image.mode.startswith("I") or (isinstance(args, tuple) and args[1] > 255)
    return width * height * (3 if head.startswith(b"P6") else 1) * (1 + wide)


class _WithoutComments:
    """A file read without its comments, from # to the end of the line, in linear time.

    Pillow copies the rest of a 1 MB block for every comment in it.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._window = io.BytesIO()
        self._in_comment = False
        self._at = 0

    def read(self, size: int) -> bytes:
        """Return at most ``size`` bytes, empty only at the end."""
        while not (data := self._window.read(size)):
            block = self._file.read(_BLOCK)
            if not block:
                return b""
            self._window = io.BytesIO(self._stripped(block))
        self._at += len(data)
        return data

    def tell(self) -> int:
        """Return the number of bytes read."""
        return self._at

    def seek(self, offset: int) -> None:
        """Seek to ``offset``, not counting comments."""
        self._file.seek(0)
        self._window = io.BytesIO()
        self._in_comment = False
        self._at = 0
        while self._at < offset and self.read(min(_BLOCK, offset - self._at)):
            pass

    def _stripped(self, block: bytes) -> bytes:
        if self._in_comment:
            block = b"#" + block
        last = block.rfind(b"#")
        self._in_comment = last >= 0 and not re.search(rb"[\r\n]", block[last:])
        return _COMMENT.sub(b"", block)


#: First bytes → reader. Image.open is not used because it rejects images of more than 179 million pixels; we apply our
#: own limit.
_READERS: tuple[tuple[bytes, type[ImageFile.ImageFile]], ...] = (
    (b"\x89PNG\r\n\x1a\n", PngImagePlugin.PngImageFile),
    (b"BM", BmpImagePlugin.BmpImageFile),
)
_IMAGES = (*_NETPBM, *(first for first, _ in _READERS))  #: first bytes of map images
_T = TypeVar("_T", bound=np.generic)
_PIXELS_PER_BYTE = 8 * 1032  #: one bit each, in a maximally compressed PNG
_ROWS = 256
_SURE = 0.99  #: p_occ of a cell with the value 100, because certainty has no finite log-odds


@dataclass(frozen=True, slots=True)
class LoadedMap:
    """A map file: the grid, and the contents of its yaml.

    ``values`` (rows, cols) int8 are those of nav_msgs/OccupancyGrid: 0 … 100, −1 unknown. In ``grid`` a value v is
    p_occ = v/100, limited to 0.01 … 0.99, and −1 is a cell never observed.
    """

    grid: OccupancyGrid
    values: NDArray[np.int8]
    description: MapDescription
    notes: tuple[str, ...] = ()


def load_map(yaml_path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> LoadedMap:
    """Return the map described by a yaml, or a map of CMU's course; its image is PGM, PNG or BMP in the same folder.

    For an image elsewhere, that of the same base name next to the yaml is used, with a note. Raises :class:`ReadError`,
    naming the key or the image, and :class:`LimitError`, before anything large is decoded.
    """
    path = Path(yaml_path)
    if is_bee_map(path):
        return _loaded_bee(path, limits)
    try:
        with path.open("rb") as file:
            data = file.read(limits.max_yaml_bytes + 1)
    except FileNotFoundError as error:
        raise ReadError("map.missing", f"There is no file {path.name!r}.") from error
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ReadError("map.unreadable", f"The file {path.name!r} cannot be read: {reason}.") from error
    if data.startswith(_IMAGES):
        raise ReadError("map.no_yaml", f"The file {path.name!r} is an image: choose the yaml that names it.")
    description = parse_description(data, limits)
    image, note = image_path(path, description.image)
    (sums, n_channels, opaque), white = _shades(image, description, limits)
    in_image_order = _values(sums, n_channels, opaque, description)
    values: NDArray[np.int8] = np.ascontiguousarray(GridGeometry.to_image(in_image_order), dtype=np.int8)
    rows, cols = values.shape
    geometry = GridGeometry(description.resolution, rows, cols, description.origin, limits)
    unknown = _note_on_unknown(sums, n_channels, description, has_alpha=opaque is not None, white=white)
    notes = (*description.notes, note, unknown, _note_on_yaw(description.origin[2]))
    return LoadedMap(grid_of_values(geometry, values), values, description, tuple(filter(None, notes)))


def grid_of_values(geometry: GridGeometry, values: NDArray[np.int8]) -> OccupancyGrid:
    """Return the grid with these nav_msgs/OccupancyGrid values (rows, cols): 0 … 100, −1 unknown."""
    grid = OccupancyGrid(geometry)
    grid.observed = values != UNKNOWN
    of_value = log_odds(np.clip(np.arange(101) / 100.0, 1.0 - _SURE, _SURE)).astype(np.float32)
    _look_up(np.append(of_value, np.float32(0.0)), values, out=grid.log_odds)  # UNKNOWN, -1, is the last
    return grid


def _loaded_bee(path: Path, limits: Limits) -> LoadedMap:
    geometry, values = read_bee_map(path, limits)
    description = MapDescription(
        path.name, geometry.resolution, geometry.origin, negate=False, occupied_thresh=OCCUPIED_THRESHOLD,
        free_thresh=FREE_THRESHOLD, mode="scale",
    )  # fmt: skip
    return LoadedMap(grid_of_values(geometry, values), values, description)


def _note_on_unknown(
    sums: NDArray[np.uint16], n_channels: int, description: MapDescription, *, has_alpha: bool, white: int
) -> str | None:
    """Return a sentence if pixels with map_saver's grey for unknown are interpreted as known.

    ``white`` is the greatest value that an image of one channel states.
    """
    if description.mode == "raw" or description.negate:
        return None
    # Of four channels, the fourth is an opaque alpha; no channels mean 16 bits.
    grey, brightest = {
        0: (257 * GREY_UNKNOWN, 65535),
        4: (3 * GREY_UNKNOWN + 255, 4 * 255),
        1: (round(GREY_UNKNOWN * 255 / white), 255),
    }.get(n_channels, (n_channels * GREY_UNKNOWN, n_channels * 255))
    occupancy = 1.0 - grey / brightest
    if description.mode == "scale":
        greys = [shade * grey // GREY_UNKNOWN for shade in (GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE)]
        if has_alpha or not np.any(sums == grey) or not np.isin(sums, greys).all():
            return None  # it is an ordinary shade of a probability
        return (
            f"The image has the three greys of map_saver, of which {GREY_UNKNOWN} says unknown, but in mode scale only "
            "an alpha channel does: it counts as known here. State mode: trinary to keep it unknown."
        )
    if occupancy >= description.free_thresh or not np.any(sums == grey):
        return None
    what = f"Grey {GREY_UNKNOWN}, which map_saver writes for unknown, counts as free here, since"
    if n_channels == 4:
        return (
            f"{what} the image has an alpha channel, which counts as a fourth colour: save the image without it, or "
            f"set free_thresh to {int(1000.0 * occupancy) / 1000.0:g} in place of {description.free_thresh:g}, to keep "
            "it unknown."
        )
    if white != 255:
        return (
            f"{what} the image’s greatest value is {white}, not 255, and free_thresh is {description.free_thresh:g}; "
            f"{int(1000.0 * occupancy) / 1000.0:g} keeps it unknown."
        )
    return f"{what} free_thresh is {description.free_thresh:g}; 0.196 keeps it unknown."


def _shades(
    path: Path, description: MapDescription, limits: Limits
) -> tuple[tuple[NDArray[np.uint16], int, NDArray[np.bool_] | None], int]:
    """Return the sum of each pixel's channels, their number (0: one channel of 16 bits), and which are opaque.

    The last value is the maximum that the image states, to which its pixels were scaled: 255 if it states none.
    """
    named = f"The map’s image {path.name!r}"
    try:
        size = path.stat().st_size
        if size > limits.max_image_bytes:
            raise LimitError("map.image_too_large", f"{named} has more than {limits.max_image_bytes} bytes.")
        with path.open("rb") as file, _opened(file, named) as image:
            width, height = image.size
            if width * height > limits.max_cells or max(width, height) > limits.max_side:
                raise LimitError(
                    "map.image_too_large",
                    f"{named} is larger than the limit of {limits.max_cells} cells, {limits.max_side} a side: "
                    f"{width} × {height}.",
                )
            if width * height > _PIXELS_PER_BYTE * size:
                raise ReadError(
                    "map.image",
                    f"{named} is damaged: it claims {width} × {height} pixels, which its {size} bytes cannot hold.",
                )
            white = _greatest(image)
            return _channel_sums(image, description), white
    except (OSError, ValueError, SyntaxError, EOFError, IndexError, struct.error, zlib.error) as error:
        raise ReadError("map.image", f"{named} is damaged: {error}.") from error


def _greatest(image: ImageFile.ImageFile) -> int:
    """Return the greatest value of a PGM of one byte, before it is decoded; 255 for another image."""
    args: Any = image.tile[0].args if image.tile and isinstance(image, PpmImagePlugin.PpmImageFile) else None
    stated = args[-1] if isinstance(args, tuple) else args
    return stated if isinstance(stated, int) and 0 < stated < 255 else 255


def _note_on_yaw(yaw: float) -> str | None:
    """Return a sentence on a map whose origin is turned, which parts of Nav2 do not follow.

    Source: StaticLayer::processMap of nav2_costmap_2d and convertMap of nav2_amcl, which read the position alone.
    """
    if abs(wrap_angle(yaw)) < 1e-6:
        return None
    return (
        f"The map’s origin is turned by {math.degrees(yaw):.4g}°, as map_server states it and as it is taken here. "
        "Nav2’s static layer and AMCL take the origin’s x and y alone: there the map lies otherwise. Turn the image "
        "instead, and state a yaw of 0."
    )


def _opened(file: BinaryIO, named: str) -> ImageFile.ImageFile:
    head = file.read(8)
    file.seek(0)
    for magic, reader in _READERS:
        if head.startswith(magic):
            return reader(file)
    if head.startswith(_NETPBM):
        return open_plain_image(file, named)
    raise ReadError("map.image", f"{named} is not a PGM, PNG or BMP image: save it as PNG.")


def _channel_sums(
    image: Image.Image, description: MapDescription
) -> tuple[NDArray[np.uint16], int, NDArray[np.bool_] | None]:
    if image.mode.startswith("I"):
        return np.asarray(image).clip(0, 65535).astype(np.uint16), 0, None
    if image.has_transparency_data:
        pixels = np.asarray(image.convert("RGBA"))
        n = 4 if description.mode == "trinary" else 3
        return pixels[..., :n].sum(axis=-1, dtype=np.uint16), n, pixels[..., 3] == 255
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L")).astype(np.uint16), 1, None
    return np.asarray(image.convert("RGB")).sum(axis=-1, dtype=np.uint16), 3, None


def _values(
    sums: NDArray[np.uint16], n_channels: int, opaque: NDArray[np.bool_] | None, description: MapDescription
) -> NDArray[np.int8]:
    """Return nav_msgs values (height, width) int8 in image order, using a table over all possible sums."""
    brightest = 255 * n_channels if n_channels else 65535
    shade = np.arange(brightest + 1) / brightest
    occupancy = shade if description.negate else 1.0 - shade
    low, high = description.free_thresh, description.occupied_thresh
    if description.mode == "raw":
        grey = np.rint(shade * 255.0)
        table = np.where(grey <= OCCUPIED, grey, UNKNOWN)
    else:
        is_scale = description.mode == "scale" and high > low
        between = np.rint((occupancy - low) / (high - low) * 100.0) if is_scale else UNKNOWN
        table = np.where(occupancy > high, OCCUPIED, np.where(occupancy < low, FREE, between))
    values = _look_up(table.astype(np.int8), sums, out=np.empty(sums.shape, dtype=np.int8))
    if description.mode == "scale" and opaque is not None:
        values[~opaque] = UNKNOWN
    return values


def _look_up(table: NDArray[_T], index: NDArray[Any], out: NDArray[_T]) -> NDArray[_T]:
    """Write ``table[index]`` into ``out``, a few rows at a time, because NumPy converts each index to eight bytes."""
    for row in range(0, len(index), _ROWS):
        out[row : row + _ROWS] = table[index[row : row + _ROWS]]
    return out
