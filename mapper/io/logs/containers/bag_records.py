"""Records of ROS 1 bags: ``<header length> <header> <data length> <data>``, with name=value fields in the header.

Source: wiki.ros.org/Bags/Format/2.0.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

VERSION = b"#ROSBAG V2.0\n"
MESSAGE, BAG_HEADER, INDEX, CHUNK = b"\x02", b"\x03", b"\x04", b"\x05"
CHUNK_INFO, CONNECTION = b"\x06", b"\x07"
MAX_FIRST_RECORD_BYTES = 1 << 13  #: it is padded to 4096

U32, U64 = struct.Struct("<I"), struct.Struct("<Q")
TIME = struct.Struct("<II")

Fields = dict[bytes, bytes]


class CutError(Exception):
    """The data ends in the middle of a record."""


class DamagedError(Exception):
    """The data is not a record."""


def fields_of(header: bytes) -> Fields:
    """Return the fields of a record's header. Raises :class:`DamagedError`."""
    fields = {}
    at = 0
    while at < len(header):
        if at + 4 > len(header):
            raise DamagedError
        (size,) = U32.unpack_from(header, at)
        at += 4
        name, equals, value = header[at : at + size].partition(b"=")
        if at + size > len(header) or not equals:
            raise DamagedError
        fields[name] = value
        at += size
    return fields


def records(data: bytes, at: int = 0) -> Iterator[tuple[Fields, bytes]]:
    """Yield the records in ``data`` from an offset on. Raises :class:`CutError` if it ends within one."""
    while at < len(data):
        if at + 4 > len(data):
            raise CutError
        (size,) = U32.unpack_from(data, at)
        body = at + 4 + size
        if body + 4 > len(data):
            raise CutError
        header = data[at + 4 : body]
        (size,) = U32.unpack_from(data, body)
        at = body + 4 + size
        if at > len(data):
            raise CutError
        fields = fields_of(header)
        if b"op" not in fields:
            raise DamagedError
        yield fields, data[body + 4 : at]


def connection_of(fields: Fields) -> int | None:
    """Return the connection of a record, None if not stated."""
    connection = fields.get(b"conn", b"")
    return int(U32.unpack(connection)[0]) if len(connection) == 4 else None


def time_ns(stated: bytes) -> int:
    """Return a time of 8 bytes in nanoseconds, 0 for invalid bytes."""
    seconds, nanoseconds = TIME.unpack(stated) if len(stated) == 8 else (0, 0)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def topic_and_type(fields: Fields, content: bytes) -> tuple[str, str]:
    """Return topic and type from a connection record. Raises :class:`DamagedError`."""
    stated = fields_of(content)
    topic, kind = stated.get(b"topic", fields.get(b"topic", b"")), stated.get(b"type", b"")
    return topic.decode("utf-8", "replace"), kind.decode("utf-8", "replace")
