"""Decoding of the Protocol Buffers wire format with tables of the required fields.

Source: protobuf.dev/programming-guides/encoding.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mapper.io.logs.ros.message_fields import BadMessageError

VARINT, BITS64, LENGTH, BITS32 = 0, 1, 2, 5  #: wire types
MOST_VARINT_BYTES = 10
MAX_DEPTH = 100  #: nesting depth of messages, as in the official decoders
#: Fixed-size number types → wire type, :mod:`struct` code and size in bytes.
FIXED = {
    "double": (BITS64, "d", 8), "fixed64": (BITS64, "Q", 8), "sfixed64": (BITS64, "q", 8),
    "float": (BITS32, "f", 4), "fixed32": (BITS32, "I", 4), "sfixed32": (BITS32, "i", 4),
}  # fmt: skip
#: Variable-size number types → conversion from their 64 bits.
VARYING: dict[str, Callable[[int], int]] = {
    "int": lambda bits: bits - (1 << 64) if bits >= 1 << 63 else bits,
    "uint": lambda bits: bits,
    "sint": lambda bits: (bits >> 1) ^ -(bits & 1),
    "bool": bool,
}
_CONTINUED = bytes(range(0x80, 0x100))  #: bytes of a varint with a continuation bit


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message: its name and type.

    ``kind`` is one of :data:`FIXED` and :data:`VARYING`, "string", "bytes" or, for a message, its own table. For a
    ``repeated`` field all values are kept, in a list. A missing ``implied`` field has its zero value.
    """

    name: str
    kind: str | Mapping[int, Field]
    repeated: bool = False
    implied: bool = False


Table = Mapping[int, Field]


def decoded(data: bytes, table: Table, depth: int = 0) -> dict[str, Any]:
    """Return the fields of a message listed in ``table``; missing ones are omitted.

    ``depth`` is the nesting depth of the message. Raises :class:`BadMessageError`.
    """
    if depth > MAX_DEPTH:
        raise BadMessageError
    message: dict[str, Any] = {}
    for number, wire, value in wire_fields(data):
        field = table.get(number)
        if field is None:
            continue
        values = _values(field, wire, value, depth)
        if field.repeated:
            message.setdefault(field.name, []).extend(values)
        else:
            message[field.name] = values[-1] if len(values) else 0.0
    return message


def _values(field: Field, wire: int, value: int | bytes, depth: int) -> list[Any]:
    kind = field.kind
    if not isinstance(kind, str):
        return [decoded(bytes_of(value), kind, depth + 1)]
    if kind in FIXED or kind in VARYING:
        return numbers(kind, wire, value)[0]
    raw = bytes_of(value)
    return [raw.decode("utf-8", "replace") if kind == "string" else raw]


def numbers(kind: str, wire: int, value: int | bytes, most: int | None = None) -> tuple[list[Any], int]:
    """Return the first ``most`` numbers of a field, which may be packed, and how many there are.

    Raises :class:`BadMessageError`.
    """
    if kind in FIXED:
        single, code, size = FIXED[kind]
        raw = bytes_of(value)
        n, rest = divmod(len(raw), size)
        if wire not in (single, LENGTH) or rest:
            raise BadMessageError
        return list(struct.unpack_from(f"<{n if most is None else min(n, most)}{code}", raw)), n
    if isinstance(value, int):
        return [VARYING[kind](value)], 1
    if wire != LENGTH:
        raise BadMessageError
    values: list[Any] = []
    at = 0
    while at < len(value) and (most is None or len(values) < most):
        bits, at = _varint(value, at)
        values.append(VARYING[kind](bits))
    return values, len(values) + len(value[at:].translate(None, _CONTINUED))


def bytes_of(value: int | bytes) -> bytes:
    """Return the value of a length-delimited field. Raises :class:`BadMessageError` for another type."""
    if not isinstance(value, bytes):
        raise BadMessageError
    return value


def wire_fields(data: bytes) -> Iterator[tuple[int, int, int | bytes]]:
    """Yield number, wire type and value of each field. Raises :class:`BadMessageError`."""
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
