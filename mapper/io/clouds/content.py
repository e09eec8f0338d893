"""Bytes of a cloud file, and the checks of points common to all cloud readers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.unpacking import Progress, Unpacked, opened
from mapper.io.logs.ros.cloud_messages import times_of
from mapper.io.logs.text.lines import with_line_feeds
from mapper.sensors.point_cloud import PointCloud

#: standard name → names, in lower case, used by PCL, CloudCompare, libpointmatcher, LAS and drivers
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
PACKED = ("rgb", "rgba")  #: one four-byte number: blue, green, red and, for rgba, alpha, lowest byte first (PCL)


def standard_fields(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return ``columns`` (n,) or (n, k) by name, with standard names where they exist.

    See :class:`mapper.sensors.point_cloud.PointCloud` for the names. All other columns keep their names.
    """
    left = dict(columns)
    lower = {name.lower(): name for name in reversed(left)}  # of two that differ in case, the first
    standard: dict[str, NDArray[Any]] = {}
    for parts in NORMALS:
        if all(part in lower for part in parts):
            standard["normals"] = np.stack([left.pop(lower.pop(part)) for part in parts], axis=1).astype(np.float64)
            break
    for parts in COLOURS:
        if all(part in lower for part in parts):
            standard["rgb"] = _bytes_of(np.stack([left.pop(lower.pop(part)) for part in parts], axis=1))
            break
    else:
        packed = next((lower[name] for name in PACKED if name in lower and _is_packed(left[lower[name]])), None)
        if packed is not None:
            standard["rgb"] = _unpacked(left.pop(packed))
    for name, others in NAMES.items():
        known = next((lower[other] for other in others if other in lower and left[lower[other]].ndim == 1), None)
        if known is not None:
            standard[name] = left.pop(known)
    return {**left, **standard}


def _is_packed(column: NDArray[Any]) -> bool:
    return column.ndim == 1 and column.dtype.itemsize == 4


def _unpacked(column: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of packed numbers (n,); integral floats are converted by value, not by bits."""
    is_whole = (column >= 0) & (column < 1 << 24) & (column == np.floor(column))
    if column.dtype.kind == "f" and is_whole.all() and column.any():
        column = column.astype(np.uint32)
    bits = np.ascontiguousarray(column).view(np.uint32)
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=1).astype(np.uint8)


def _bytes_of(colours: NDArray[Any]) -> NDArray[np.uint8]:
    """Convert colours (n, 3) of 0 … 255, of 0 … 1 (floats) or of 0 … 65535 (16 bits) to bytes."""
    if colours.dtype == np.uint8:
        return colours
    known = colours.astype(np.float64)
    most = float(np.nanmax(known, initial=0.0))
    if colours.dtype.kind == "f" and most <= 1.0:
        known = known * 255.0
    elif most > 255.0:
        known = known / 257.0
    return np.clip(np.nan_to_num(known), 0.0, 255.0).round().astype(np.uint8)


COARSE_STEP_M = 0.001  #: coordinates rounded more coarsely are noted


HEAD_BYTES = 1 << 12  #: read to detect a format


def content(
    path: Path, limits: Limits, progress: Progress | None = None, check: Callable[[bytes], object] | None = None
) -> bytes:
    """Return the bytes of the file at ``path``, decompressed from gzip or Zstandard if necessary.

    ``check`` receives the first :data:`HEAD_BYTES` before the rest is read, and may raise. Raises :class:`ReadError`
    for a file that cannot be read, is empty or contains damaged compressed data, and :class:`LimitError` for one with
    more bytes than ``limits`` allow.
    """
    parts: list[bytes] = []
    size = 0
    with opened(path) as file:
        unpacked = Unpacked(file, lambda: f"after byte {size}", limits, progress)
        for piece in unpacked:
            size += len(piece)
            if size > limits.max_cloud_bytes:
                raise LimitError(
                    "cloud.too_many_bytes",
                    f"{path.name!r} has more than {limits.max_cloud_bytes} bytes, the limit of one cloud.",
                )
            parts.append(piece)
            if check is not None and size >= HEAD_BYTES > size - len(piece):
                check(b"".join(parts)[:HEAD_BYTES])
        if unpacked.broken is not None:
            raise ReadError("cloud.truncated", f"The {unpacked.packing} data {unpacked.broken}, after byte {size}.")
    return b"".join(parts)


def plain_text(data: bytes) -> bytes:
    """Return a text without its byte-order mark, converted to UTF-8 if that indicates UTF-16; other data unchanged.

    Carriage-return line ends are converted to line feeds.
    """
    if b"\0\0\0" in data[:64]:
        return data
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = data.decode("utf-16", "replace").encode()
    return with_line_feeds(data.removeprefix(b"\xef\xbb\xbf"))


def check_count(n: int, limits: Limits) -> None:
    """Raise :class:`ReadError` for a negative number of points and :class:`LimitError` for too many."""
    if n < 0:
        raise ReadError("cloud.count", f"The header says that the cloud has {n} points.")
    if n > limits.max_points:
        raise LimitError(
            "cloud.too_many_points", f"The header says {n} points, more than the limit of {limits.max_points}."
        )


def ended_early(claimed: int, there: int) -> tuple[str, ...]:
    """Return the note on a file that ends before all its points, or none.

    Raises :class:`ReadError` if it has no point at all.
    """
    if there >= claimed:
        return ()
    if there == 0:
        raise ReadError("cloud.truncated", f"The file ends early: its header says {claimed} points, and it has none.")
    return (f"The file ends early: {claimed} points claimed, {there} there; these are read.",)


def made_cloud(
    points: NDArray[Any],
    columns: Mapping[str, NDArray[Any]],
    limits: Limits,
    shape: tuple[int, int] | None = None,
    sensor_pose: NDArray[np.float64] | None = None,
    notes: tuple[str, ...] = (),
) -> PointCloud:
    """Return the cloud of ``points`` (n, 3) with ``columns`` as fields, by their standard names.

    ``notes`` come before those on the points. Non-finite points, and those beyond ``max_coordinate``, which become NaN,
    are counted in its notes, which also state the resolution of coordinates too large for their float32. Raises
    :class:`ReadError` for a cloud without points.
    """
    n = len(points)
    if n == 0:
        raise ReadError("cloud.empty", "The file holds no points.")
    places = np.array(points, dtype=np.float64, order="C")
    all_notes = [*notes]
    finite = np.asarray(np.isfinite(places).all(axis=1))
    if not finite.any():
        raise ReadError("cloud.no_places", f"None of the {n} points is finite.")
    if not finite.all():
        first = int(np.argmin(finite))
        all_notes.append(f"{n - int(finite.sum())} of {n} points are not finite, the first at index {first}.")
    far: NDArray[np.bool_] = np.abs(np.where(finite[:, np.newaxis], places, 0.0)).max(axis=1) > limits.max_coordinate
    if far.any():
        first = int(np.argmax(far))
        all_notes.append(
            f"{int(far.sum())} of {n} points are more than {limits.max_coordinate:g} m from the origin and are left "
            f"out, the first at index {first}: {', '.join(f'{value:g}' for value in places[first])}."
        )
        places[far] = np.nan
        if not (finite & ~far).any():
            raise ReadError(
                "cloud.no_places",
                f"None of the {n} points is finite and within {limits.max_coordinate:g} m of the origin.",
            )
    if points.dtype == np.float32:
        farthest = np.float32(np.nanmax(np.where(finite[:, np.newaxis], np.abs(places), 0.0)))
        step = float(np.spacing(farthest))
        if step > COARSE_STEP_M:
            all_notes.append(
                f"The coordinates are 32-bit numbers: at {farthest:.0f} m they have steps of {step:g} m. Subtract an "
                "offset before saving, or save them as 64-bit numbers, to keep what is finer."
            )
    fields = standard_fields(columns)
    return PointCloud(places, 0, "", shape, fields, times_of(fields, 0), sensor_pose, tuple(all_notes))
