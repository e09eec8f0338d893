"""Write maps as nav2's map_saver does: an image and the yaml that describes it.

Source: nav2_map_server, map_io.cpp. The modes:

``trinary``  a PGM of three greys: 0 occupied, 254 free, 205 unknown
``scale``    a PNG, grey (100 − v) % for a value v of 0 … 100, transparent where nothing was observed
``raw``      a PGM whose grey is the value 0 … 100 itself, 255 where nothing was observed

The three states are told apart at p_occ 0.65 and 0.25. A trinary yaml states 0.65 and 0.196 all the same, as
map_saver's does: its reader takes grey 205 for an occupancy of (255 − 205) / 255 = 0.196, so that any higher
``free_thresh`` would turn the unknown free. A scale yaml states 1 and 0, between which the reader stretches the greys.
"""

from __future__ import annotations

import io
import json
import os
import re
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mapper.compare import Difference
from mapper.errors import ConfigError
from mapper.files import whole_file
from mapper.grid import (
    FREE,
    FREE_THRESHOLD,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    UNKNOWN,
    GridGeometry,
    OccupancyGrid,
    probability,
)

Mode = Literal["trinary", "scale", "raw"]

GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE = 0, 205, 254
RAW_UNKNOWN = 255
#: (occupied_thresh, free_thresh) that a yaml of each mode states, so that what is read is what was written
STATED_THRESHOLDS: dict[Mode, tuple[float, float]] = {
    "trinary": (OCCUPIED_THRESHOLD, 0.196),
    "scale": (1.0, 0.0),
    "raw": (OCCUPIED_THRESHOLD, FREE_THRESHOLD),
}
UNOBSERVED_RGB = (176, 196, 222)  #: pale blue: no grey, so it is mistaken for no probability
DIFFERENCE_RGB = ((21, 95, 158), (241, 238, 230), (166, 62, 8))  #: more free, the same, more occupied
APART_RGB = (*(228, 224, 212), *(196, 178, 214), *(214, 200, 150))  #: observed in neither map, in a, in b only
FRAME_KEY = "gridbloom_frame"  #: of the yaml, which by itself has no place for the map's frame
_PLAIN_NAME = re.compile(r"[A-Za-z][A-Za-z0-9._-]*\Z")


def occupancy_values(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> NDArray[np.int8]:
    """Return p_occ in per cent (rows, cols) int8, −1 where nothing was observed, as nav_msgs/OccupancyGrid has it.

    Rounding never carries a cell over a threshold: it has the same three-way state as :meth:`OccupancyGrid.classify`
    says.
    """
    state = grid.classify(occupied_threshold, free_threshold)
    values = np.rint(100.0 * probability(grid.log_odds)).astype(np.int8)
    low, high = int(np.floor(100.0 * free_threshold)) + 1, int(np.ceil(100.0 * occupied_threshold)) - 1
    values = np.where(state == UNKNOWN, np.clip(values, low, high), values)
    values = np.where(state == OCCUPIED, np.maximum(values, np.floor(100.0 * occupied_threshold) + 1), values)
    values = np.where(state == FREE, np.minimum(values, np.ceil(100.0 * free_threshold) - 1), values)
    return np.where(grid.observed, values, UNKNOWN).astype(np.int8)


def pgm_bytes(
    grid: OccupancyGrid,
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
    mode: Mode = "trinary",
) -> bytes:
    """Return the map as a binary PGM, top row first, in mode ``trinary`` or ``raw``. Raises :class:`ConfigError`."""
    if mode == "trinary":
        state = grid.classify(occupied_threshold, free_threshold)
        grey = np.full(state.shape, GREY_UNKNOWN, dtype=np.uint8)
        grey[state == OCCUPIED] = GREY_OCCUPIED
        grey[state == FREE] = GREY_FREE
    elif mode == "raw":
        values = occupancy_values(grid, occupied_threshold, free_threshold)
        grey = np.where(values == UNKNOWN, RAW_UNKNOWN, values).astype(np.uint8)
    else:
        raise ConfigError(
            "map.mode", f"A PGM holds a trinary or a raw map, not mode {mode!r}, which needs transparency."
        )
    rows, cols = grid.geometry.shape
    return f"P5\n{cols} {rows}\n255\n".encode() + GridGeometry.to_image(grey).tobytes()


def scale_png_bytes(
    grid: OccupancyGrid, occupied_threshold: float = OCCUPIED_THRESHOLD, free_threshold: float = FREE_THRESHOLD
) -> bytes:
    """Return the map as a PNG with transparency, for mode ``scale``."""
    values = occupancy_values(grid, occupied_threshold, free_threshold)
    grey = np.where(values == UNKNOWN, 128, np.rint((100.0 - values) * 2.55)).astype(np.uint8)
    alpha = np.where(values == UNKNOWN, 0, 255).astype(np.uint8)
    return _png(Image.fromarray(np.ascontiguousarray(GridGeometry.to_image(np.stack([grey, alpha], axis=-1)))))


def png_bytes(grid: OccupancyGrid) -> bytes:
    """Return a picture of p_occ: white is surely free, black surely occupied, pale blue never observed. Top row first.

    It is to be looked at, not to be read back.
    """
    index = np.rint(254.0 * (1.0 - probability(grid.log_odds))).astype(np.uint8)
    index[~grid.observed] = 255
    image = Image.fromarray(np.ascontiguousarray(GridGeometry.to_image(index)))
    greys = np.rint(np.arange(255) * 255.0 / 254.0).astype(int)
    image.putpalette([*np.repeat(greys, 3).tolist(), *UNOBSERVED_RGB])
    return _png(image)


def difference_png_bytes(difference: Difference) -> bytes:
    """Return a picture of ℓ_b − ℓ_a, top row first: orange is more occupied in b, blue more free, the palest neither.

    The strongest colour is the greatest difference there is, and strength grows with the square root, so that small
    ones can be seen. Lilac was observed only in a, sand only in b, and grey in neither. It is to be looked at.
    """
    known = difference.observed_a & difference.observed_b
    apart = np.where(known, difference.log_odds, 0.0)
    most = max(float(np.abs(apart).max()), 1e-6)
    strength = np.rint(np.sqrt(np.abs(apart) / most) * 126.0)
    index = (129 + np.copysign(strength, apart)).astype(np.uint8)
    index[difference.observed_a & ~difference.observed_b] = 1
    index[difference.observed_b & ~difference.observed_a] = 2
    index[~(difference.observed_a | difference.observed_b)] = 0
    image = Image.fromarray(np.ascontiguousarray(GridGeometry.to_image(index)))
    ramp = np.linspace(0.0, 1.0, 127)[:, None]
    less, none, more = (np.array(rgb, dtype=np.float64) for rgb in DIFFERENCE_RGB)
    colours = np.concatenate([(none + (less - none) * ramp)[:0:-1], none + (more - none) * ramp])
    image.putpalette([*APART_RGB, *np.rint(colours).astype(int).ravel().tolist()])
    return _png(image)


def _png(image: Image.Image) -> bytes:
    out = io.BytesIO()
    image.save(out, "PNG")
    return out.getvalue()


def yaml_text(
    geometry: GridGeometry,
    image_name: str,
    mode: Mode = "trinary",
    *,
    occupied_thresh: float | None = None,
    free_thresh: float | None = None,
    frame: str | None = None,
) -> str:
    """Return the yaml for an image beside it: resolution in m, origin as the pose (x, y, yaw) of the lower-left corner.

    The thresholds are those to read the image with, not those it was made with: :data:`STATED_THRESHOLDS` unless given.
    ``frame`` is the map's frame (None: not stated). It stands under a key of our own, :data:`FRAME_KEY`; map_server and
    Nav2 read the keys that they know and ignore others.
    """
    stated = STATED_THRESHOLDS[mode]
    occupied = stated[0] if occupied_thresh is None else occupied_thresh
    free = stated[1] if free_thresh is None else free_thresh
    origin = ", ".join(_number(value) for value in geometry.origin)
    stated_frame = "" if frame is None else f"{FRAME_KEY}: {_word(frame)}\n"
    return (
        f"image: {_word(image_name)}\nmode: {mode}\nresolution: {_number(geometry.resolution)}\norigin: [{origin}]\n"
        f"negate: 0\noccupied_thresh: {_number(occupied)}\nfree_thresh: {_number(free)}\n{stated_frame}"
    )


def _word(text: str) -> str:
    return text if _PLAIN_NAME.match(text) else _quoted(text)


def _quoted(text: str) -> str:
    """Return a word in quotes, with escapes for what YAML forbids, and for what turns or breaks the line."""
    quoted = json.dumps(text, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in quoted)


def _number(value: float) -> str:
    """Return a number as every YAML has it: for YAML 1.1 ``1e-05`` is a word, and ``1.0e-05`` the number."""
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")


def save_map(
    grid: OccupancyGrid,
    prefix: str | os.PathLike[str],
    mode: Mode = "trinary",
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
    frame: str | None = None,
) -> tuple[Path, Path]:
    """Write ``prefix.yaml`` and its image, ``prefix.pgm`` (``prefix.png`` in mode scale); return both paths.

    ``frame`` is the frame that the map is in, where it is known. Folders are made. Each file appears whole or not at
    all, the image before the yaml. Raises :class:`ConfigError` where a file cannot be written.
    """
    base = Path(prefix)
    if not base.name:
        raise ConfigError("map.prefix", f"A map needs a file name, which {str(prefix)!r} lacks.")
    image_path = base.with_name(base.name + (".png" if mode == "scale" else ".pgm"))
    yaml_path = base.with_name(base.name + ".yaml")
    if mode == "scale":
        image = scale_png_bytes(grid, occupied_threshold, free_threshold)
    else:
        image = pgm_bytes(grid, occupied_threshold, free_threshold, mode)
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        for path, data in (
            (image_path, image),
            (yaml_path, yaml_text(grid.geometry, image_path.name, mode, frame=frame).encode()),
        ):
            with whole_file(path) as file:
                file.write(data)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError("map.unwritable", f"The map {base.name!r} cannot be written: {reason}.") from error
    return yaml_path, image_path
