"""PGM and PNG images as pieces of bytes, generated from bands of rows: a large image is never held in memory.

Source: netpbm's description of PGM; PNG specification, third edition (chunks, section 5; filter type 0, section 9).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
PIECE_BYTES = 1 << 18  #: compressed bytes per IDAT chunk
_GREY, _PALETTE, _GREY_ALPHA = 0, 3, 4  # colour types of PNG

Bands = Iterable[NDArray[np.uint8]]


def pgm_header(shape: tuple[int, int]) -> bytes:
    """Return the header of a binary PGM of ``shape`` (rows, cols)."""
    rows, cols = shape
    return f"P5\n{cols} {rows}\n255\n".encode()


def pgm_pieces(shape: tuple[int, int], bands: Bands) -> Iterator[bytes]:
    """Yield a binary PGM of ``shape`` (rows, cols). ``bands`` (n, cols) uint8 are its rows, top first."""
    yield pgm_header(shape)
    for band in bands:
        yield band.tobytes()


def png_pieces(shape: tuple[int, int], bands: Bands, palette: bytes | None = None) -> Iterator[bytes]:
    """Yield a PNG of ``shape`` (rows, cols).

    ``bands`` uint8 are its rows, top first: (n, cols) grey, or indices into ``palette``, three bytes (red, green, blue)
    per index; or (n, cols, 2) grey and alpha.
    """
    rows, cols = shape
    bands = iter(bands)
    first = next(bands)
    colour = _PALETTE if palette is not None else _GREY if first.ndim == 2 else _GREY_ALPHA
    yield SIGNATURE + _chunk(b"IHDR", struct.pack(">IIBBBBB", cols, rows, 8, colour, 0, 0, 0))
    if palette is not None:
        yield _chunk(b"PLTE", palette)
    # Filter 0, as recommended for palette images, because differences of indices are meaningless, and maps are mostly
    # runs.
    compressor = zlib.compressobj()
    waiting = bytearray(compressor.compress(_filtered(first)))
    for band in bands:
        waiting += compressor.compress(_filtered(band))
        if len(waiting) >= PIECE_BYTES:
            yield _chunk(b"IDAT", bytes(waiting))
            waiting.clear()
    yield _chunk(b"IDAT", bytes(waiting) + compressor.flush()) + _chunk(b"IEND", b"")


def _filtered(band: NDArray[np.uint8]) -> bytes:
    """Return rows in the form that the PNG compressor uses, each preceded by its filter number."""
    rows = band.reshape(len(band), -1)
    return np.concatenate([np.zeros((len(rows), 1), np.uint8), rows], axis=1).tobytes()


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))
