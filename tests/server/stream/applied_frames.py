"""Frames of a grid's layer applied to an array, as the protocol's text says, without the service's decoder."""

from __future__ import annotations

import struct

import numpy as np
import zstandard
from numpy.typing import NDArray

TILE = 64


def apply_frame(data: bytes, cells: NDArray[np.int8]) -> tuple[int, list[tuple[int, int]]]:
    """Write a frame of tiles or changes to ``cells`` (rows, cols); return its newest revision and its (ty, tx)."""
    kind, count = data[0], struct.unpack_from("<I", data, 12)[0]
    return (_apply_tiles if kind == 1 else _apply_changes)(data, count, cells)


def _apply_tiles(data: bytes, count: int, cells: NDArray[np.int8]) -> tuple[int, list[tuple[int, int]]]:
    at, newest, places = 16, 0, []
    for _ in range(count):
        tx, ty, revision, nbytes = struct.unpack_from("<hhII", data, at)
        at += 12
        tile = np.frombuffer(zstandard.decompress(data[at : at + nbytes]), dtype=np.int8).reshape(TILE, TILE)
        at += nbytes
        into = cells[TILE * ty : TILE * ty + TILE, TILE * tx : TILE * tx + TILE]
        into[:] = tile[: into.shape[0], : into.shape[1]]
        newest = max(newest, revision)
        places.append((ty, tx))
    assert at == len(data)
    return newest, places


def _apply_changes(data: bytes, count: int, cells: NDArray[np.int8]) -> tuple[int, list[tuple[int, int]]]:
    assert data[0] == 4
    (revision,) = struct.unpack_from("<I", data, 16)
    tiles = [struct.unpack_from("<hhHH", data, 20 + 8 * i) for i in range(count)]
    total = sum(tile[2] for tile in tiles)
    at = 20 + 8 * count
    assert len(data) == at + 3 * total
    i = 0
    for tx, ty, number, reserved in tiles:
        assert reserved == 0
        for _ in range(number):
            (place,) = struct.unpack_from("<H", data, at + 2 * i)
            (value,) = struct.unpack_from("<b", data, at + 2 * total + i)
            cells[TILE * ty + place // TILE, TILE * tx + place % TILE] = value
            i += 1
    return revision, [(ty, tx) for tx, ty, _, _ in tiles]
