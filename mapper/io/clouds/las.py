"""Point clouds of airborne and ground lidar: LAS, and LAZ, its compressed form.

Source: the ASPRS LAS specification 1.4. Both are read by laspy (LAZ with lazrs), part by part.
"""

from __future__ import annotations

import io
import logging
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import MapperError, ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import check_count, made_cloud
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

PART = 1 << 20  #: points that are unpacked at a time
HEADER_BYTES = 227  #: of the shortest version
DIMENSIONS = ("intensity", "classification", "return_number", "number_of_returns", "gps_time", "red", "green", "blue")


def read_las(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a LAS or LAZ file, with intensity, class, returns, times and colours where it has them.

    Raises :class:`ReadError` for a file that is damaged or cut, and :class:`LimitError`.
    """
    import laspy  # noqa: PLC0415 # only who reads this format pays for it

    logging.getLogger("laspy").setLevel(logging.CRITICAL)  # what it says there, an error says here

    if len(data) < HEADER_BYTES:
        raise ReadError("cloud.truncated", "The file ends within its LAS header.")
    try:
        with laspy.open(io.BytesIO(data), closefd=False) as reader:
            header = reader.header
            n = int(header.point_count)
            check_count(n, limits)
            if n == 0:
                return made_cloud(np.zeros((0, 3)), {}, limits)
            size, there = int(header.point_format.size), len(data) - int(header.offset_to_point_data)
            if not header.are_points_compressed and there < n * size:
                raise ReadError("cloud.truncated", f"The file ends early: {n} points claimed, {there} bytes there.")
            names = [name for name in DIMENSIONS if name in set(header.point_format.dimension_names)]
            points, columns = _parts(reader, n, names)
    except MapperError:
        raise
    except Exception as error:
        raise _damaged(error) from error
    except BaseException as error:  # lazrs reports a defect in Rust as one that is no Exception
        if type(error).__name__ != "PanicException":
            raise
        raise _damaged(error) from error
    return made_cloud(points, columns, limits)


def _parts(reader: Any, n: int, names: list[str]) -> tuple[NDArray[np.float64], dict[str, NDArray[Any]]]:  # noqa: ANN401
    points: list[NDArray[np.float64]] = []
    columns: dict[str, list[NDArray[Any]]] = {name: [] for name in names}
    read = 0
    while read < n:
        part = reader.read_points(min(PART, n - read))
        if len(part) == 0:
            raise ReadError("cloud.truncated", f"The file ends early: {n} points claimed, {read} there.")
        read += len(part)
        points.append(np.stack([np.asarray(part.x), np.asarray(part.y), np.asarray(part.z)], axis=1))
        for name in names:
            columns[name].append(np.array(part[name]))
    return np.concatenate(points), {name: np.concatenate(parts) for name, parts in columns.items()}


def _damaged(error: BaseException) -> ReadError:
    return ReadError("cloud.damaged", f"The LAS file is damaged or cut: {printable(str(error)[:120])}.")
