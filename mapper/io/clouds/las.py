"""Point clouds of airborne and terrestrial lidar: LAS, and its compressed form LAZ.

Source: the ASPRS LAS specification 1.4. Both are read by laspy (LAZ with lazrs) in parts, after the numbers in the
header have been checked against the available bytes, because laspy processes as many records as a header claims.
"""

from __future__ import annotations

import io
import logging
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import MapperError, ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.content import check_count, ended_early, made_cloud
from mapper.io.clouds.degrees import have_steps_of_degrees, metres_of_degrees
from mapper.io.clouds.projection import USER, Units, units_of
from mapper.io.logs.names import printable
from mapper.sensors.point_cloud import PointCloud

PART = 1 << 20  #: points decompressed at a time
SMALL_PART, PARTS = 1 << 12, 256  #: maximum size, and minimum number, of parts of a file that ends early
NEWEST = (1, 4)  #: version
HEADER_BYTES = 227  #: of the oldest version
RECORD_BYTES, EXTENDED_BYTES = 54, 60  #: of the header of a variable-length record, and of an extended one
LEAST_POINT_BYTES = 20  #: of a point in any format
DIMENSIONS = ("intensity", "classification", "return_number", "number_of_returns", "gps_time", "red", "green", "blue")


def read_las(data: bytes, limits: Limits) -> PointCloud:
    """Return the points of a LAS or LAZ file, with intensity, class, returns, times and colours if it has them.

    Coordinates in feet or degrees, by the file's projection record, are converted to metres with a note. For a file
    that ends early these are the available points, with a note. Raises :class:`ReadError` for a damaged file, and
    :class:`LimitError`.
    """
    data, notes = _checked(data)
    is_packed = _sizes(data).is_packed
    try:
        if is_packed and _chunk_table(data) is None:
            return _read(_with_table(data, len(data)), limits, notes, is_cut=True)
        return _read(data, limits, notes)
    except MapperError:
        raise
    except Exception as error:
        table = _chunk_table(data) if is_packed else None
        if table is None:
            raise _damaged(error) from error
        failure: BaseException = error
    except BaseException as error:  # lazrs reports errors in Rust with a class that is not an Exception
        if type(error).__name__ != "PanicException":
            raise
        raise _damaged(error) from error
    try:  # the chunk table is cut, or a chunk is damaged; the points before it are valid
        return _read(_with_table(data, table), limits, notes, is_cut=True)
    except MapperError:
        raise
    except Exception as error:
        raise _damaged(failure) from error
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        raise _damaged(error) from error


def _read(data: bytes, limits: Limits, notes: tuple[str, ...], *, is_cut: bool = False) -> PointCloud:
    import laspy  # noqa: PLC0415 # only who reads this format pays for it

    logging.getLogger("laspy").setLevel(logging.CRITICAL)  # our error contains its message
    # The parallel reader uses the chunk table, the other one goes from one chunk to the next.
    backend = laspy.LazBackend.Lazrs if is_cut else None
    with laspy.open(io.BytesIO(data), closefd=False, laz_backend=backend) as reader:
        header = reader.header
        if not (np.isfinite(header.scales).all() and np.all(header.scales)):
            steps = ", ".join(f"{step:g}" for step in header.scales)
            raise ReadError("cloud.scale", f"The LAS header has scale factors of {steps}: all points would be one.")
        n = int(header.point_count)
        check_count(n, limits)
        there = (_points_end(data) - int(header.offset_to_point_data)) // int(header.point_format.size)
        if header.are_points_compressed:
            there = n
        elif 0 < n < there:
            notes = (*notes, f"The header says {n} points, which are read; bytes of {there - n} more follow them.")
        elif n == 0 < there:
            check_count(there, limits)
            notes = (*notes, f"The header says 0 points, and {there} are there: it was not written to the end.")
            header.point_count = n = there
        if n == 0:
            return made_cloud(np.zeros((0, 3)), {}, limits)
        names = [name for name in DIMENSIONS if name in set(header.point_format.dimension_names)]
        points, columns = _parts(reader, min(n, there), names, is_cut=is_cut)
        notes = (*notes, *ended_early(n, len(points)))
        points, converted = _in_metres(points, _units(reader), tuple(map(float, header.scales)))
    return made_cloud(points, columns, limits, notes=(*notes, *converted))


@dataclass(frozen=True, slots=True)
class _Sizes:
    """The offsets and sizes of records and points in the public header."""

    header: int
    points_at: int
    records: int
    is_packed: bool
    extended_at: int
    extended: int


def _sizes(data: bytes) -> _Sizes:
    header, points_at, records, point_format = struct.unpack_from("<HIIB", data, 94)
    extended_at, extended = struct.unpack_from("<QI", data, 235) if data[25] >= 4 and len(data) >= 375 else (0, 0)
    return _Sizes(header, points_at, records, bool(point_format & 0x80), extended_at, extended)


def _points_end(data: bytes) -> int:
    """Return the maximum end of uncompressed points: before waveforms, extended records or the end of the file."""
    sizes = _sizes(data)
    (waveforms_at,) = struct.unpack_from("<Q", data, 227) if data[25] >= 3 and len(data) >= 235 else (0,)
    ends = (waveforms_at, sizes.extended_at if sizes.extended else 0)
    return min([len(data), *(end for end in ends if end >= sizes.points_at)])


def _checked(data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """Return the file without extended records that do not fit into it, and a note on them.

    Raises :class:`ReadError` for a file that ends within its header or its records, or claims more records than fit.
    """
    if len(data) < HEADER_BYTES:
        raise ReadError("cloud.truncated", "The file ends within its LAS header.")
    if (data[24], data[25]) > NEWEST:
        raise ReadError("cloud.version", f"The file is LAS {data[24]}.{data[25]}; versions up to 1.4 are read.")
    sizes = _sizes(data)
    if sizes.points_at > len(data) or sizes.header > sizes.points_at:
        raise ReadError(
            "cloud.truncated",
            f"The file ends before its points: they begin at byte {sizes.points_at}, and it has {len(data)}.",
        )
    room = sizes.points_at - sizes.header
    if sizes.records * RECORD_BYTES > room:
        raise ReadError(
            "cloud.header",
            f"The LAS header claims {sizes.records} variable-length records, which do not fit into the {room} bytes "
            "before the points.",
        )
    if sizes.extended and sizes.extended_at + sizes.extended * EXTENDED_BYTES > len(data):
        without = bytearray(data)
        struct.pack_into("<QI", without, 235, 0, 0)
        return bytes(without), (f"{sizes.extended} extended records at its end are not in the file.",)
    return data, ()


def _chunk_table(data: bytes) -> int | None:
    """Return the start of the chunk table of compressed points; None if it is not in the file.

    Also None if it claims more chunks than fit before it, each with its uncompressed first point, because lazrs
    allocates memory for the claimed number, and aborts the process if there is none.
    """
    at = _sizes(data).points_at
    if at + 8 > len(data):
        return None
    table = int(struct.unpack_from("<q", data, at)[0])
    if not at + 8 <= table <= len(data) - 8:
        return None
    (chunks,) = struct.unpack_from("<I", data, table + 4)
    return table if chunks * LEAST_POINT_BYTES <= table - at - 8 else None


def _with_table(data: bytes, end: int) -> bytes:
    """Return compressed points up to byte ``end`` with an empty chunk table, which lazrs requires."""
    at = _sizes(data).points_at
    return data[:at] + struct.pack("<q", end) + data[at + 8 : end] + bytes(8)


def _parts(
    reader: Any,  # noqa: ANN401
    n: int,
    names: list[str],
    *,
    is_cut: bool,
) -> tuple[NDArray[np.float64], dict[str, NDArray[Any]]]:
    points: list[NDArray[np.float64]] = [np.zeros((0, 3))]
    columns: dict[str, list[NDArray[Any]]] = {name: [] for name in names}
    read = 0
    size = max(1, min(SMALL_PART, n // PARTS)) if is_cut else PART
    while read < n:
        try:
            part = reader.read_points(min(size, n - read))
        except Exception as error:
            if not is_cut:
                raise
            if read == 0:
                raise ReadError(
                    "cloud.truncated",
                    "The compressed points end early, or are damaged, within their first chunk, so none can be read.",
                ) from error
            break
        if len(part) == 0:
            break
        read += len(part)
        points.append(np.stack([np.asarray(part.x), np.asarray(part.y), np.asarray(part.z)], axis=1))
        for name in names:
            columns[name].append(np.array(part[name]))
    return np.concatenate(points), {name: np.concatenate(parts) for name, parts in columns.items() if parts}


def _units(reader: Any) -> Units | None:  # noqa: ANN401
    records = {}
    for vlr in (*(reader.header.evlrs or ()), *reader.header.vlrs):
        if str(vlr.user_id).strip("\0 ") == USER:
            records[int(vlr.record_id)] = bytes(vlr.record_data_bytes())
    return units_of(records)


def _in_metres(
    points: NDArray[np.float64], units: Units | None, steps: tuple[float, ...]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Return points (n, 3) in metres, and notes on the conversion; ``steps`` are the resolutions of stored
    coordinates.
    """
    if (units is None or units.model == "projected") and have_steps_of_degrees(points, steps):
        stated = "states no units" if units is None else f"states the unit {units.horizontal[0]!r}"
        why = f"The file {stated}, but x and y have steps of {steps[0]:g} and z of {steps[2]:g}, as degrees have"
        points[:, :2], note = metres_of_degrees(points[:, :2], why)
        return points, (note,)
    if units is None:
        return points, ()
    notes: list[str] = []
    is_converted = False
    name, size = units.horizontal
    height = units.vertical
    if units.unstated is not None:
        raise ReadError(
            "cloud.units",
            f"The projection record names EPSG:{units.unstated} and no unit of its coordinates, which the file does "
            "not tell either: state it in the record (ProjLinearUnitsGeoKey, or WKT), or project the cloud to UTM.",
        )
    if units.model == "geographic":
        why = "The coordinates are longitude and latitude in degrees, by the file’s projection record"
        degrees = np.degrees(points[:, :2] * size)
        metres, note = metres_of_degrees(degrees, why)
        if metres is not degrees:
            points[:, :2] = metres
        notes.append(note)
    elif units.model == "geocentric":
        notes.append("The coordinates are geocentric, by the file’s projection record: z is not upward.")
    elif abs(size - 1.0) > 1e-9:
        points[:, :2] *= size
        is_converted = True
        height = height or units.horizontal
        notes.append(f"x and y are in the unit {name!r}, by the file’s projection record; {size:.9g} m each.")
    if height is not None and abs(height[1] - 1.0) > 1e-9:
        points[:, 2] *= height[1]
        is_converted = True
        stated = "the file’s projection record" if units.vertical else "that of x and y, as no other is stated"
        notes.append(f"z is in the unit {height[0]!r}, by {stated}; {height[1]:.9g} m each.")
    if is_converted:
        notes.append("All are converted to metres.")
    return points, tuple(notes)


def _damaged(error: BaseException) -> ReadError:
    return ReadError("cloud.damaged", f"The LAS file is damaged or cut: {printable(str(error)[:120])}.")
