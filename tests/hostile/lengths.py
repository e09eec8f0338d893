"""The positions of length fields in a valid bag or MCAP file, found by parsing it.

Source: wiki.ros.org/Bags/Format/2.0; mcap.dev/spec.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

#: Opcode → what an MCAP record is made of: bytes to pass over, a string, bytes or a map after a length of 4 bytes, or
#: "data" after one of 8.
MCAP_RECORDS: dict[int, tuple[int | str, ...]] = {
    0x01: ("string", "string"),  # header
    0x02: (20,),  # footer
    0x03: (2, "string", "string", "bytes"),  # schema
    0x04: (4, "string", "string", "map"),  # channel
    0x05: (22,),  # message; its data goes to the record's end
    0x06: (28, "string", "data"),  # chunk
    0x07: (2, "map"),  # message index
    0x08: (32, "map", 8, "string", 16),  # chunk index
    0x0B: (42, "map"),  # statistics
    0x0E: (17,),  # summary offset
    0x0F: (4,),  # data end
}


def in_mcap(data: bytes, start: int = 8, end: int | None = None) -> Iterator[tuple[int, int]]:
    """Yield place and size in bytes of every length in an MCAP file, also those in its uncompressed chunks."""
    at = start
    end = len(data) - 8 if end is None else end
    while at < end:
        opcode, size = struct.unpack_from("<BQ", data, at)
        yield at + 1, 8
        at += 9
        pos = at
        for part in MCAP_RECORDS[opcode]:
            if isinstance(part, int):
                pos += part
                continue
            width = 8 if part == "data" else 4
            (length,) = struct.unpack_from("<Q" if width == 8 else "<I", data, pos)
            yield pos, width
            if part == "data":
                yield pos - 16, 8  # "" and its length, the checksum, and the size when uncompressed
                yield from in_mcap(data, pos + 8, pos + 8 + length)
            pos += width + length
        at += size


def in_bag(data: bytes, start: int = 13, end: int | None = None) -> Iterator[tuple[int, int]]:
    """Yield place and size in bytes of every length in a bag, also those in its uncompressed chunks."""
    at = start
    end = len(data) if end is None else end
    while at < end:
        (size,) = struct.unpack_from("<I", data, at)
        yield at, 4
        body = at + 4 + size
        fields = dict(_fields(data, at + 4, body))
        yield from ((place, 4) for place in fields.values())
        (size,) = struct.unpack_from("<I", data, body)
        yield body, 4
        op = data[fields[b"op"] + 7]
        if op == 0x05:
            yield from in_bag(data, body + 4, body + 4 + size)
        elif op == 0x07:
            yield from ((place, 4) for _, place in _fields(data, body + 4, body + 4 + size))
        at = body + 4 + size


def _fields(data: bytes, start: int, end: int) -> Iterator[tuple[bytes, int]]:
    at = start
    while at < end:
        (size,) = struct.unpack_from("<I", data, at)
        yield data[at + 4 : at + 4 + size].partition(b"=")[0], at
        at += 4 + size


def lies(size: int) -> tuple[bytes, ...]:
    """Return what a length of ``size`` bytes may be made to say: most, most that is positive, four billion, nothing."""
    most = (1 << 8 * size) - 1
    return tuple(value.to_bytes(size, "little") for value in {most, most >> 1, 0xFFFFFFFF, 0x7FFFFFFF, 0})
