"""Point clouds as PLY files. Source: Greg Turk's description of PLY (1994)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array

#: Names in the file of what is known of points; others keep theirs.
_NAMES = {"rgb": ("red", "green", "blue"), "class": ("classification",)}
_TYPES = {"u1": "uchar", "i1": "char", "u2": "ushort", "i2": "short", "u4": "uint", "i4": "int", "f4": "float"}


def points_ply(points: Float32Array, fields: Mapping[str, NDArray[Any]], offset: Float64Array) -> bytes:
    """Return points (n, 3), metres, with their ``fields`` (n,) or (n, k) as a binary PLY file.

    ``offset`` (3,) is a comment: what is added to the points is in the coordinates of the file that was mapped. A field
    of a type that PLY lacks, as 64 bits, is written as float.
    """
    columns: dict[str, NDArray[Any]] = {name: points[:, n] for n, name in enumerate("xyz")}
    for name, values in fields.items():
        parts = values if values.ndim == 2 else values[:, None]
        names = _NAMES.get(name, (name,))
        columns |= {names[n] if n < len(names) else f"{name}_{n}": parts[:, n] for n in range(parts.shape[1])}
    kinds = {name: values.dtype.str[1:] if values.dtype.str[1:] in _TYPES else "f4" for name, values in columns.items()}
    rows = np.empty(len(points), dtype=[(name, f"<{kind}") for name, kind in kinds.items()])
    for name, values in columns.items():
        rows[name] = values
    moved = f"comment offset {' '.join(map(repr, offset.tolist()))}\n" if offset.any() else ""
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment metres, z up\n{moved}element vertex {len(points)}\n"
        + "".join(f"property {_TYPES[kind]} {name}\n" for name, kind in kinds.items())
        + "end_header\n"
    )
    return header.encode() + rows.tobytes()
