"""Messages in the Protocol Buffers wire format, by tables of the fields that are wanted.

A library that decodes any message takes its definition from the file; here none is read from it, as for ROS messages.
Source: protobuf.dev/programming-guides/encoding.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mapper.io.logs.ros.message_fields import BadMessageError

VARINT, BITS64, LENGTH, BITS32 = 0, 1, 2, 5  #: wire types
MOST_VARINT_BYTES = 10


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message: its name and what it is.

    ``kind`` is "int", "fixed32", "double", "string", "bytes" or, for a message, its own table. Of a ``repeated`` one
    all values are kept, in a list.
    """

    name: str
    kind: str | Mapping[int, Field]
    repeated: bool = False


Table = Mapping[int, Field]


def decoded(data: bytes, table: Table) -> dict[str, Any]:
    """Return the fields of a message that ``table`` names; one that is missing is left out.

    Raises :class:`BadMessageError`.
    """
    found: dict[str, Any] = {}
    for number, wire, value in _fields(data):
        field = table.get(number)
        if field is None:
            continue
        values = _values(field, wire, value)
        if field.repeated:
            found.setdefault(field.name, []).extend(values)
        else:
            found[field.name] = values[-1] if len(values) else 0.0
    return found


def _values(field: Field, wire: int, value: int | bytes) -> list[Any]:
    kind = field.kind
    if not isinstance(kind, str):
        return [decoded(_bytes(value), kind)]
    if kind == "double":
        if wire == BITS64:
            return list(struct.unpack("<d", _bytes(value)))
        raw = _bytes(value)
        if wire != LENGTH or len(raw) % 8:
            raise BadMessageError
        return list(struct.unpack(f"<{len(raw) // 8}d", raw))
    if kind == "fixed32":
        if wire != BITS32:
            raise BadMessageError
        return list(struct.unpack("<I", _bytes(value)))
    if kind == "int":
        if not isinstance(value, int):
            raise BadMessageError
        return [value - (1 << 64) if value >= 1 << 63 else value]
    raw = _bytes(value)
    return [raw.decode("utf-8", "replace") if kind == "string" else raw]


def _bytes(value: int | bytes) -> bytes:
    if not isinstance(value, bytes):
        raise BadMessageError
    return value


def _fields(data: bytes) -> Iterator[tuple[int, int, int | bytes]]:
    """Yield number, wire type and value of each field."""
    at = 0
    while at < len(data):
        tag, at = _varint(data, at)
        number, wire = tag >> 3, tag & 7
        if wire == VARINT:
            value, at = _varint(data, at)
            yield number, wire, value
            continue
        if wire == LENGTH:
            size, at = _varint(data, at)
        elif wire in (BITS64, BITS32):
            size = 8 if wire == BITS64 else 4
        else:
            raise BadMessageError
        if size > len(data) - at:
            raise BadMessageError
        yield number, wire, data[at : at + size]
        at += size


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for shift in range(MOST_VARINT_BYTES):
        if at >= len(data):
            raise BadMessageError
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << (7 * shift)
        if byte < 0x80:
            return value & ((1 << 64) - 1), at
    raise BadMessageError
