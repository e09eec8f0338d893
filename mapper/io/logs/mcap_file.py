"""MCAP files with ROS messages (the default of ROS 2 bags), chunks plain, lz4 or zstd; the whole file gzip or zstd.

Source: mcap.dev/spec. After the magic bytes come records ``<opcode u8> <length u64> <content>``; most are in chunks.

Records are read from front to back, each no larger than what is there, and expanded as streams with a cap; the mcap
library, whose own readers trust every length and expand a chunk in one call, decodes what is in a record.
"""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Schema

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archive import Source
from mapper.io.logs.bytestream import ByteStream, byte_stream
from mapper.io.logs.container import Container
from mapper.io.logs.inflate import inflate
from mapper.io.logs.recording import Recording
from mapper.io.logs.unpacking import Progress, opened

MAGIC = b"\x89MCAP0\r\n"
ENCODINGS = {"cdr": True, "ros1": False}  #: of messages → whether it is CDR
SCHEMA_ENCODINGS = frozenset({"ros2msg", "ros2idl", "ros1msg"})

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")  #: channel, sequence, log time, publish time
_END = struct.Struct("<BQQQI8s")  #: the footer record (summary start, summary offset start, CRC) and the magic bytes
_AFTER_CRC = 12  #: bytes of the file's end from the summary's checksum on
MAX_SUMMARY_BYTES = 1 << 24
_BAD_RECORD = (struct.error, ValueError, McapError, MemoryError, OverflowError)


class _CutError(Exception):
    """The data ends in the middle of a record."""


class _DamagedError(Exception):
    """The data is no record."""


def _records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of each record in a chunk. Raises :class:`_CutError` where it ends within one."""
    at, n = 0, len(data)
    while at < n:
        if at + 9 > n:
            raise _CutError
        opcode, size = _RECORD.unpack_from(data, at)
        if opcode == 0:
            raise _DamagedError
        end = at + 9 + size
        if end > n:
            raise _CutError
        yield opcode, at + 9, end
        at = end


class _Mcap:
    def __init__(self, stream: ByteStream, recording: Recording, limits: Limits) -> None:
        self.stream = stream
        self.recording = recording
        self.limits = limits
        self.schemas: dict[int, tuple[str, str]] = {}  #: id → name, encoding
        self.expanded = 0
        self.records = 0

    def read(self) -> None:
        """Hand everything to the recording that can be read; note what cannot."""
        self.stream.skip(len(MAGIC))
        try:
            while self._record():
                pass
        except _CutError:
            self.recording.notes.append(f"The file ends early, at byte {self.stream.at}: only what precedes is read.")
        except _DamagedError:
            self.recording.notes.append(f"The file is damaged before byte {self.stream.at}: the rest is left out.")

    def look_ahead(self, file: BinaryIO) -> None:
        """Take the schemas and channels that a whole, uncompressed file repeats at its end.

        They are first in the chunks: without this, a damaged chunk would take all later messages of its channels
        with it. What is wrong here is no harm: the chunks say it again.
        """
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - _END.size))
        end = file.read(_END.size)
        if len(end) < _END.size or not end.endswith(MAGIC):
            return
        opcode, length, start, _, stated, _ = _END.unpack(end)
        if opcode != Opcode.FOOTER or length != 20 or not len(MAGIC) < start < size - _END.size:
            return
        file.seek(start)
        summary = file.read(min(size - start, MAX_SUMMARY_BYTES))
        # The checksum is that of the summary and of the footer up to where it stands itself.
        if stated and len(summary) == size - start and zlib.crc32(summary[:-_AFTER_CRC]) != stated:
            self._note("The summary at the file's end has not the checksum that it states, and is not used.")
            return
        with contextlib.suppress(_CutError, _DamagedError):
            for opcode, at, stop in _records(summary):
                if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._content(opcode, summary, at, stop)

    def _record(self) -> bool:
        """Read one record; return whether more may come: the data ends with its own record."""
        crc = self.stream.crc
        head = self.stream.read(9)
        if len(head) < 9:
            raise _CutError
        opcode, size = _RECORD.unpack(head)
        if opcode == 0:
            raise _DamagedError
        self._count_record()
        if opcode in (Opcode.CHUNK, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.DATA_END):
            at = self.stream.at
            content = self.stream.read(size)
            cut = len(content) < size
            if opcode == Opcode.CHUNK:
                self._chunk(content, at, cut=cut)
            elif not cut:
                self._content(opcode, content, 0, size)
            if cut:
                raise _CutError
            if opcode == Opcode.DATA_END:
                stated = _decoded(DataEnd.read, content).data_section_crc
                if stated not in (0, crc):
                    self._note("The file's checksum is not that of its bytes: something in it is damaged.")
                return False
        elif self.stream.skip(size) < size:
            raise _CutError
        return True

    def _chunk(self, content: bytes, at: int, *, cut: bool) -> None:
        damaged = f"The chunk at byte {at} is damaged; its messages, or their rest, are left out."
        try:
            chunk = _decoded(Chunk.read, content)
            data = chunk.data
            if chunk.compression in ("zstd", "lz4"):
                data, _ = inflate(chunk.compression, data, self.limits.max_chunk_bytes, f"the chunk at byte {at}")
            elif chunk.compression:
                self._note(
                    f"The chunk at byte {at} is compressed in an unknown way, {chunk.compression!r:.40}, "
                    "and is left out."
                )
                return
        except (_DamagedError, ReadError):
            if not cut:
                self._note(damaged)
            return
        self.expanded += len(data)
        if self.expanded > self.limits.max_log_bytes:
            raise LimitError(
                "log.too_many_bytes",
                f"The file expands to more than the limit of {self.limits.max_log_bytes} bytes.",
            )
        if not cut and chunk.uncompressed_crc not in (0, zlib.crc32(data)):
            self._note(f"The chunk at byte {at} has not the checksum that it states, and is left out.")
            return
        try:
            for opcode, start, end in _records(data):
                self._count_record()
                self._content(opcode, data, start, end)
        except _DamagedError:
            self._note(damaged)
        except _CutError:
            if not cut:
                self._note(damaged)

    def _count_record(self) -> None:
        self.records += 1
        if self.records > self.limits.max_messages:
            raise LimitError("log.too_many_messages", f"The file has more than {self.limits.max_messages} records.")

    def _content(self, opcode: int, data: bytes, start: int, end: int) -> None:
        """Take a message, a channel or a schema."""
        if opcode == Opcode.MESSAGE:
            if end - start < _MESSAGE.size:
                raise _DamagedError
            key, _, time, _ = _MESSAGE.unpack_from(data, start)
            wanted = self.recording.wants(key)
            self.recording.take(key, time, data[start + _MESSAGE.size : end] if wanted else b"")
        elif opcode == Opcode.SCHEMA:
            # Only its name is of use: what it defines is known, or not read (see ros_messages).
            schema = _decoded(Schema.read, data[start:end])
            self.schemas[schema.id] = (schema.name, schema.encoding)
        elif opcode == Opcode.CHANNEL:
            channel = _decoded(Channel.read, data[start:end])
            name, encoding = self.schemas.get(channel.schema_id, ("", ""))
            self.recording.channel(
                channel.id,
                channel.topic,
                name,
                cdr=ENCODINGS.get(channel.message_encoding, True),
                readable=channel.message_encoding in ENCODINGS and encoding in SCHEMA_ENCODINGS,
            )

    def _note(self, sentence: str) -> None:
        if len(self.recording.notes) < 20:
            self.recording.notes.append(sentence)


def _decoded(read, content: bytes):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202 - any of the library's records
    try:
        return read(ReadDataStream(BytesIO(content)))
    except _BAD_RECORD:
        raise _DamagedError from None


def take_mcap(file: Source, recording: Recording, limits: Limits, progress: Progress | None) -> None:
    """Hand what an MCAP file holds over to ``recording``; of one that is cut or damaged, what could be read.

    Raises :class:`ReadError` where nothing could be, and :class:`LimitError`.
    """
    with byte_stream(file, limits, progress) as stream:
        mcap = _Mcap(stream, recording, limits)
        with opened(file) as raw:
            mcap.look_ahead(raw)
        mcap.read()
        recording.notes += stream.notes


MCAP = Container("MCAP", take_mcap)
