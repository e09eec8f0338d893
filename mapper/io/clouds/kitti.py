"""Velodyne scans of KITTI and nuScenes (.bin): 32-bit numbers, point by point.

Source: the development kits of KITTI ("x, y, z and reflectance", 0 to 1) and of nuScenes (``LidarPointCloud``: x, y, z,
intensity, 0 to 255, ring), in the sensor's frame. Such a file has no header and is recognised by its values.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import check_count, made_cloud
from mapper.sensors.point_cloud import PointCloud

#: a point's numbers after x, y and z, and the datasets that use them, the narrower form first
FORMS = {("intensity",): "KITTI", ("intensity", "ring"): "nuScenes"}
LEAST_POINTS = 16  #: fewer are not enough for recognition
NEAR_M, REACH_M, FAR_M = 0.3, 2.0, 500.0
MOST_WHOLE = 255


def looks_like_kitti(head: bytes) -> bool:
    """Return whether a file that starts with ``head`` contains points without a header."""
    return _form_of(head) is not None


def read_kitti(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a file without a header, with a note on the assumed format.

    Raises :class:`ReadError` if the points after the first ones are invalid.
    """
    names = _form_of(data)
    if names is None or len(data) % _width(names):
        raise ReadError(
            "cloud.format", "The file begins with points of 32-bit numbers but does not continue with them."
        )
    records = _records(data, names)
    check_count(len(records), limits)
    note = (
        f"The file has no header: it is read as one of {FORMS[names]}, 32-bit x, y, z, {', '.join(names)} of each "
        "point in the sensor’s frame."
    )
    fields = dict(zip(names, records[:, 3:].T, strict=True))
    return made_cloud(records[:, :3], fields, limits, sensor_pose=np.eye(4), notes=(note,))


def _width(names: tuple[str, ...]) -> int:
    return 4 * (3 + len(names))


def _records(data: bytes, names: tuple[str, ...]) -> NDArray[np.float32]:
    columns = 3 + len(names)
    return np.frombuffer(data, "<f4", len(data) // _width(names) * columns).reshape(-1, columns)


def _form_of(data: bytes) -> tuple[str, ...] | None:
    """Return the names of the numbers after x, y and z in the records of ``data``; None if they are not points.

    The intensities must be 0 to 1 or, like rings, integers of one byte; at least half of the points must be no nearer
    than :data:`NEAR_M`, one farther than :data:`REACH_M`, and none farther than :data:`FAR_M`. Digits of a text read in
    this way are numbers near 0, and those of any other table occur in all columns.
    """
    return next((names for names in FORMS if _are_points(_records(data, names))), None)


def _are_points(records: NDArray[np.float32]) -> bool:
    if len(records) < LEAST_POINTS or not np.isfinite(records).all():
        return False
    with np.errstate(over="ignore"):
        away = np.sqrt(np.sum(np.square(records[:, :3]), axis=1))
    is_place = np.median(away) >= NEAR_M and REACH_M < away.max() <= FAR_M
    return bool(is_place) and all(_are_marks(column) for column in records[:, 3:].T)


def _are_marks(column: NDArray[np.float32]) -> bool:
    """Return whether numbers are intensities or rings."""
    if column.min() < 0.0 or column.max() > MOST_WHOLE:
        return False
    return bool(column.max() <= 1.0 or np.array_equal(column, np.floor(column)))
