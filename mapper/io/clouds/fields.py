"""The names that formats and programs give to fields of points, as the standard names of a PointCloud's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: standard name → the names, in lower case, under which PCL, CloudCompare, libpointmatcher, LAS and drivers store it
NAMES = {
    "intensity": (
        "intensity",
        "scalar_intensity",
        "intensities",
        "i",
        "reflectivity",
        "reflectance",
        "scalar_reflectance",
    ),
    "class": ("class", "classification", "label", "scalar_classification", "scalar_label"),
    "ring": ("ring", "channel", "line"),
}
NORMALS = (("normal_x", "normal_y", "normal_z"), ("nx", "ny", "nz"), ("n_x", "n_y", "n_z"))
COLOURS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
PACKED = ("rgb", "rgba")  #: one number of four bytes: blue, green, red and, of rgba, alpha, the lowest first (PCL)


def standard_fields(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return ``columns`` (n,) or (n, k) by name, with those that have a standard name under that.

    See :class:`mapper.sensors.point_cloud.PointCloud` for the names. Every other column keeps its own.
    """
    left = dict(columns)
    lower = {name.lower(): name for name in reversed(left)}  # of two that differ in case, the first
    made: dict[str, NDArray[Any]] = {}
    for parts in NORMALS:
        if all(part in lower for part in parts):
            made["normals"] = np.stack([left.pop(lower.pop(part)) for part in parts], axis=1).astype(np.float64)
            break
    for parts in COLOURS:
        if all(part in lower for part in parts):
            made["rgb"] = _bytes_of(np.stack([left.pop(lower.pop(part)) for part in parts], axis=1))
            break
    else:
        packed = next((lower[name] for name in PACKED if name in lower and _is_packed(left[lower[name]])), None)
        if packed is not None:
            made["rgb"] = _unpacked(left.pop(packed))
    for name, others in NAMES.items():
        known = next((lower[other] for other in others if other in lower and left[lower[other]].ndim == 1), None)
        if known is not None:
            made[name] = left.pop(known)
    return {**left, **made}


def _is_packed(column: NDArray[Any]) -> bool:
    return column.ndim == 1 and column.dtype.itemsize == 4


def _unpacked(column: NDArray[Any]) -> NDArray[np.uint8]:
    bits = np.ascontiguousarray(column).view(np.uint32)
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=1).astype(np.uint8)


def _bytes_of(colours: NDArray[Any]) -> NDArray[np.uint8]:
    """Return colours (n, 3) of 0 … 255, of 0 … 1 (floats) or of 0 … 65535 (16 bits) as bytes."""
    if colours.dtype == np.uint8:
        return colours
    known = colours.astype(np.float64)
    most = float(np.nanmax(known, initial=0.0))
    if colours.dtype.kind == "f" and most <= 1.0:
        known = known * 255.0
    elif most > 255.0:
        known = known / 257.0
    return np.clip(np.nan_to_num(known), 0.0, 255.0).round().astype(np.uint8)
