"""Records of MCAP files: ``<opcode u8> <length u64> <content>``. Source: mcap.dev/spec."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError

RECORD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")  #: channel, sequence, log time, publish time
CHUNK = struct.Struct("<QQQI")  #: start time, end time, uncompressed size, CRC; then a string and the data's length
MESSAGE_INDEX = struct.Struct("<BQHI")  #: opcode and length of a message index, channel, size of the following data
INDEX_ENTRY_BYTES = 16
U32, U64 = struct.Struct("<I"), struct.Struct("<Q")
END = struct.Struct("<BQQQI8s")  #: the footer record (summary start, summary offset start, CRC) and the magic bytes
AFTER_CRC = 12  #: bytes from the summary's checksum to the end of the file
_BAD_RECORD = (struct.error, ValueError, McapError, MemoryError, OverflowError)


class CutError(Exception):
    """The data ends in the middle of a record."""


class DamagedError(Exception):
    """The data is not a record."""


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of each record in a chunk. Raises :class:`CutError` if it ends within one."""
    at, n = 0, len(data)
    while at < n:
        if at + 9 > n:
            raise CutError
        opcode, size = RECORD.unpack_from(data, at)
        if opcode == 0:
            raise DamagedError
        end = at + 9 + size
        if end > n:
            raise CutError
        yield opcode, at + 9, end
        at = end


@dataclass(frozen=True, slots=True)
class ChunkHead:
    """Header of a chunk: ``at`` is its offset in the log, ``data_bytes`` the size in the file."""

    at: int
    crc: int
    compression: str
    data_bytes: int


def decoded(read, content: bytes):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201 - any of the library's records
    """Return a record decoded by the mcap library. Raises :class:`DamagedError`."""
    try:
        return read(ReadDataStream(BytesIO(content)))
    except _BAD_RECORD:
        raise DamagedError from None
