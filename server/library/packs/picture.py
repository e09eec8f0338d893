"""The picture of a log's map on its card: a small PNG with a palette, which is replaced for a dark page."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from mapper.core.array_types import UInt8Array
from mapper.core.atomic_file import atomic_write
from mapper.replay.overview import map_overview
from mapper.sensors.scan import ScanLog

#: Colours of map cells by code: unobserved (transparent), free, occupied, the path.
_MAP_LIGHT = ((229, 224, 207), (179, 213, 244), (107, 38, 5), (8, 112, 95))
_MAP_DARK = ((14, 18, 26), (47, 91, 133), (255, 178, 125), (84, 211, 186))
HEIGHTS = (4, 16)  #: the first code of the heights of clouds, and their number


def _between(*colours: tuple[int, int, int]) -> tuple[tuple[int, int, int], ...]:
    at = np.linspace(0.0, len(colours) - 1.0, HEIGHTS[1])
    mixed = [np.interp(at, range(len(colours)), [colour[k] for colour in colours]).astype(int) for k in range(3)]
    return tuple((int(r), int(g), int(b)) for r, g, b in zip(*mixed, strict=True))


#: By code: those of maps, then heights from low to high.
LIGHT = (*_MAP_LIGHT, *_between((120, 176, 220), (0, 122, 122), (190, 120, 0), (107, 38, 5)))
DARK = (*_MAP_DARK, *_between((47, 91, 133), (60, 170, 160), (235, 190, 90), (255, 178, 125)))


def write_picture(log: ScanLog, path: Path) -> bool:
    """Draw ``log`` into the file ``path``; return whether there was anything to draw. Raises :class:`OSError`."""
    codes = map_overview(log)
    if codes is None:
        return False
    write_codes(codes, path)
    return True


def png_of(codes: UInt8Array) -> bytes:
    """Return a picture of ``codes`` (rows, cols), first row on top, as PNG in the colours of a light page."""
    image = Image.fromarray(codes, mode="P")
    image.putpalette([value for colour in LIGHT for value in colour])
    out = io.BytesIO()
    image.save(out, format="PNG", optimize=True, transparency=0)
    return out.getvalue()


def write_codes(codes: UInt8Array, path: Path) -> None:
    """Write the picture of ``codes``."""
    with atomic_write(path) as file:
        file.write(png_of(codes))


def read_picture(path: Path, *, dark: bool) -> bytes:
    """Return the picture as PNG, in the colours of a light or a dark page. Raises :class:`OSError`."""
    plain = path.read_bytes()
    if not dark:
        return plain
    with Image.open(io.BytesIO(plain)) as image:
        image.load()
        image.putpalette([value for colour in DARK for value in colour])
        out = io.BytesIO()
        image.save(out, format="PNG", transparency=0)
    return out.getvalue()
