"""MCAP files with ROS messages (the default of ROS 2 bags), chunks plain, lz4 or zstd; the whole file gzip or zstd.

Source: mcap.dev/spec. After the magic bytes come records ``<opcode u8> <length u64> <content>``; most are in chunks.

Records are read sequentially, each no larger than the available data, and decompressed as streams with a cap. The mcap
library, whose own readers trust every length and decompress a chunk in one call, decodes the contents of records.

Only the data that a map needs is read from a plain file: large messages that are not used are skipped, also in plain
chunks, and so are compressed chunks that contain only such messages according to the indexes after them. A checksum is
verified if all of its bytes were read.
"""

from __future__ import annotations

import contextlib
import os
import zlib
from collections.abc import Iterator
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, Schema

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.bytestream import WORTH_A_JUMP, ByteStream, Section, byte_stream
from mapper.io.logs.archives.inflate import inflate
from mapper.io.logs.archives.unpacking import Progress, opened
from mapper.io.logs.containers.container import Container
from mapper.io.logs.containers.mcap_records import (
    AFTER_CRC,
    CHUNK,
    END,
    INDEX_ENTRY_BYTES,
    MESSAGE,
    MESSAGE_INDEX,
    RECORD,
    U32,
    U64,
    ChunkHead,
    CutError,
    DamagedError,
    decoded,
    records,
)
from mapper.io.logs.names import printable
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.transcoding import Transcoding
from mapper.io.logs.ros import foxglove
from mapper.io.logs.ros.ros_messages import plain_type

MAGIC = b"\x89MCAP0\r\n"
ENCODINGS = {"cdr": True, "ros1": False}  #: message encodings → whether it is CDR
#: Schema encodings of ROS messages. Some writers leave the schema empty; the type is then given by its name.
SCHEMA_ENCODINGS = frozenset({"ros2msg", "ros2idl", "ros1msg", "omgidl", ""})

CALLER = "callerid"  #: metadata of a channel converted from a ROS 1 connection: the publishing node

MAX_SUMMARY_BYTES = 1 << 24
MAX_COMPRESSION_NAME = 100  #: bytes
READ_WHOLE = 1 << 18  #: maximum size in bytes of a plain chunk that is read in one piece to verify its checksum


class _Mcap:
    def __init__(self, stream: ByteStream, recording: Transcoding, limits: Limits) -> None:
        self.stream = stream
        self.recording = recording
        self.limits = limits
        self.schemas: dict[int, tuple[str, str]] = {}  #: id → name, encoding
        self.channels: set[int] = set()  #: channels noted, if there was something to note
        self.knows_all_channels = False  #: whether the file's summary was read
        self.expanded = 0
        self.most_expanded = limits.unpacked_bytes(stream.file_size)
        self.records = 0
        self.most_records = limits.records(stream.file_size)

    def read(self) -> None:
        """Pass all readable messages to the recording; note what is unreadable."""
        self.stream.skip(len(MAGIC))
        try:
            while self._record():
                pass
        except CutError:
            self.recording.notes.append(f"The file ends early, at byte {self.stream.at}: only what precedes is read.")
        except DamagedError:
            self.recording.notes.append(f"The file is damaged before byte {self.stream.at}: the rest is left out.")

    def look_ahead(self, file: BinaryIO) -> None:
        """Read the schemas and channels repeated at the end of a complete, uncompressed file.

        They are first in the chunks, so a damaged chunk would otherwise cost all later messages of its channels. Errors
        here are harmless, because the chunks repeat them.
        """
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - END.size))
        end = file.read(END.size)
        if len(end) < END.size or not end.endswith(MAGIC):
            return
        opcode, length, start, _, stated, _ = END.unpack(end)
        if opcode != Opcode.FOOTER or length != 20 or not len(MAGIC) < start < size - END.size:
            return
        file.seek(start)
        summary = file.read(min(size - start, MAX_SUMMARY_BYTES))
        # The checksum covers the summary and the footer up to the checksum itself.
        if stated and len(summary) == size - start and zlib.crc32(summary[:-AFTER_CRC]) != stated:
            self._note("The summary at the file’s end has not the checksum that it states, and is not used.")
            return
        with contextlib.suppress(CutError, DamagedError):
            for opcode, at, stop in records(summary):
                if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._content(opcode, summary, at, stop)
                if opcode == Opcode.FOOTER:
                    self.knows_all_channels = True
                    break

    def _record(self) -> bool:
        """Read one record; return whether more may follow. The data ends with a special record."""
        crc = self.stream.crc
        head = self.stream.read(9)
        if len(head) < 9:
            raise CutError
        opcode, size = RECORD.unpack(head)
        if opcode == 0:
            raise DamagedError
        self._count_record()
        if opcode == Opcode.CHUNK:
            self._chunk(size)
        elif opcode == Opcode.MESSAGE and size >= WORTH_A_JUMP:
            data = self._message_if_wanted(self.stream, size)
            if data is not None:
                self._content(opcode, data, 0, size)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.DATA_END):
            content = self._exactly(size)
            self._content(opcode, content, 0, size)
            if opcode == Opcode.DATA_END:
                stated = decoded(DataEnd.read, content).data_section_crc
                if crc is not None and stated not in (0, crc):
                    self._note("The file’s checksum is not that of its bytes: something in it is damaged.")
                return False
        elif self.stream.skip(size) < size:
            raise CutError
        return True

    def _exactly(self, n: int) -> bytes:
        data = self.stream.read(n)
        if len(data) < n:
            raise CutError
        return data

    def _message_if_wanted(self, source: ByteStream | Section, size: int) -> bytes | None:
        """Return a message record of ``size`` bytes; skip and count it if it is not used."""
        head = source.read(MESSAGE.size)
        if len(head) < MESSAGE.size:
            raise CutError
        key, _, time, _ = MESSAGE.unpack(head)
        rest = size - len(head)
        if self.recording.wants(key):
            data = source.read(rest)
            if len(data) < rest:
                raise CutError
            return head + data
        if source.skip(rest) < rest:
            raise CutError
        self.recording.take(key, time, b"", size=rest)
        return None

    # -- chunks -------------------------------------------------------------------------------------------------

    def _chunk(self, size: int) -> None:
        """Read a chunk record of ``size`` bytes. Raises :class:`CutError` if the file ends in it."""
        end = self.stream.at + size
        head = self._chunk_head(size)
        if head is None:
            if self.stream.skip(end - self.stream.at) < end - self.stream.at:
                raise CutError
            self._note(_damaged_chunk(end - size))
            return
        more = end - self.stream.at - head.data_bytes  # 0, unless a later version of the format adds fields
        if not head.compression and self.stream.can_jump and head.data_bytes > READ_WHOLE:
            self._plain_chunk(head)
        elif not (head.compression and self._skipped_by_index(head.data_bytes + more, head.data_bytes)):
            data = self.stream.read(head.data_bytes)
            self._chunk_data(head, data, cut=len(data) < head.data_bytes)
            if len(data) < head.data_bytes:
                raise CutError
        if self.stream.skip(more) < more:
            raise CutError

    def _chunk_head(self, size: int) -> ChunkHead | None:
        """Return the header of a chunk record of ``size`` bytes; None if it is impossible."""
        at = self.stream.at
        if size < CHUNK.size + 12:
            return None
        _, _, _, crc = CHUNK.unpack(self._exactly(CHUNK.size))
        (n,) = U32.unpack(self._exactly(4))
        if n > min(MAX_COMPRESSION_NAME, size - CHUNK.size - 12):
            return None
        compression = self._exactly(n).decode("utf-8", "replace")
        (data_bytes,) = U64.unpack(self._exactly(8))
        if data_bytes > size - (self.stream.at - at):
            return None
        return ChunkHead(at, crc, compression, data_bytes)

    def _skipped_by_index(self, ahead: int, data_bytes: int) -> bool:
        """Skip a compressed chunk's data, and count its messages, if none of them is used.

        That is determined from the message indexes after the chunk record, ``ahead`` bytes from here.
        """
        counts: dict[int, int] = {}
        while (
            self.knows_all_channels and len(index := self.stream.ahead(ahead, MESSAGE_INDEX.size)) == MESSAGE_INDEX.size
        ):
            opcode, length, key, entries = MESSAGE_INDEX.unpack(index)
            if opcode != Opcode.MESSAGE_INDEX:
                break
            if self.recording.wants(key) or not self.recording.knows(key) or entries + 6 > length:
                return False
            counts[key] = counts.get(key, 0) + entries // INDEX_ENTRY_BYTES
            ahead += 9 + length
        if not counts:
            return False
        if self.stream.skip(data_bytes) < data_bytes:
            raise CutError
        for key, count in counts.items():
            self.recording.pass_over(key, count)
        return True

    def _plain_chunk(self, head: ChunkHead) -> None:
        """Read the used messages of an uncompressed chunk, whose data comes next.

        If all of it was read, its checksum is verified, and nothing from a damaged chunk is used. Channels are
        processed immediately, because they determine which messages are read.
        """
        section = Section(self.stream, head.data_bytes)
        records: list[bytes] = []
        size = 0
        is_cut = is_damaged = False
        try:
            for message in self._wanted_of(section):
                records.append(message)
                size += len(message)
                if size > self.limits.max_chunk_bytes:
                    raise LimitError(
                        "log.chunk_too_large",
                        f"The chunk at byte {head.at} has more than the limit of {self.limits.max_chunk_bytes} bytes.",
                    )
        except CutError:
            is_cut = True
        except DamagedError:
            is_damaged = True
            section.skip(section.left)
            is_cut = section.left > 0
        if not is_cut and section.crc is not None and head.crc not in (0, section.crc):
            self._note_checksum(head)
            return
        for message in records:
            self._content(Opcode.MESSAGE, message, 0, len(message))
        if is_cut:
            raise CutError
        if is_damaged:
            self._note(_damaged_chunk(head.at))

    def _wanted_of(self, section: Section) -> Iterator[bytes]:
        """Yield the used messages in a chunk's data; process its schemas and channels."""
        while section.left:
            record = section.read(9)
            if len(record) < 9:
                raise DamagedError if section.left == 0 else CutError
            opcode, size = RECORD.unpack(record)
            if opcode == 0 or size > section.left:
                raise DamagedError
            self._count_record()
            if opcode == Opcode.MESSAGE and size >= MESSAGE.size:
                message = self._message_if_wanted(section, size)
                if message is not None:
                    yield message
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                content = section.read(size)
                if len(content) < size:
                    raise CutError
                self._content(opcode, content, 0, size)
            elif section.skip(size) < size:
                raise CutError

    def _chunk_data(self, head: ChunkHead, data: bytes, *, cut: bool) -> None:
        """Process the contents of a chunk's data, which is all that the file has of it."""
        damaged = _damaged_chunk(head.at)
        if head.compression in ("zstd", "lz4"):
            try:
                data, _ = inflate(head.compression, data, self.limits.max_chunk_bytes, f"the chunk at byte {head.at}")
            except ReadError:
                if not cut:
                    self._note(damaged)
                    return
                data = b""
            if cut and not data:
                self._note(
                    f"The file ends within the chunk at byte {head.at}, whose {head.compression} data cannot be "
                    "unpacked without its end: its messages are lost."
                )
            self.expanded += len(data)
            if self.expanded > self.most_expanded:
                raise LimitError(
                    "log.too_many_bytes",
                    f"The file’s chunks expand to more than the limit of {self.most_expanded} bytes.",
                )
        elif head.compression:
            self._note(
                f"The chunk at byte {head.at} is compressed in an unknown way, {head.compression!r:.40}, "
                "and is left out."
            )
            return
        if not cut and head.crc not in (0, zlib.crc32(data)):
            self._note_checksum(head)
            return
        try:
            for opcode, start, end in records(data):
                self._count_record()
                self._content(opcode, data, start, end)
        except DamagedError:
            self._note(damaged)
        except CutError:
            if not cut:
                self._note(damaged)

    # -- records ------------------------------------------------------------------------------------------------

    def _count_record(self) -> None:
        self.records += 1
        if self.records > self.most_records:
            raise LimitError("log.too_many_messages", f"The file has more than {self.most_records} records.")

    def _content(self, opcode: int, data: bytes, start: int, end: int) -> None:
        """Process a message, a channel or a schema."""
        if opcode == Opcode.MESSAGE:
            if end - start < MESSAGE.size:
                raise DamagedError
            key, _, time, _ = MESSAGE.unpack_from(data, start)
            at = start + MESSAGE.size
            self.recording.take(key, time, data[at:end] if self.recording.wants(key) else b"", size=end - at)
        elif opcode == Opcode.SCHEMA:
            # Only its name is used: known types have fixed definitions, others are not read (see ros_messages).
            schema = decoded(Schema.read, data[start:end])
            self.schemas[schema.id] = (schema.name, schema.encoding)
        elif opcode == Opcode.CHANNEL:
            self._channel(decoded(Channel.read, data[start:end]))

    def _channel(self, channel: Channel) -> None:
        key, topic, encoding = channel.id, channel.topic, channel.message_encoding
        schema, stated = self.schemas.get(channel.schema_id, ("", ""))
        is_new = key not in self.channels
        self.channels.add(key)
        if self.recording.foxglove_channel(key, topic, schema, encoding):
            self.recording.published_by(key, channel.metadata.get(CALLER, ""))
            return
        other = encoding if encoding not in ENCODINGS else stated if stated not in SCHEMA_ENCODINGS else None
        readable = other is None or self.recording.as_recorded
        self.recording.channel(key, topic, schema, cdr=ENCODINGS.get(encoding, True), readable=readable)
        self.recording.published_by(key, channel.metadata.get(CALLER, ""))
        if is_new and other is not None and (not schema or foxglove.is_of_use(plain_type(schema))):
            what = printable(schema[:100]) or "messages without a schema"
            part = "messages are" if other is encoding else "schema is"
            self._note(
                f"{what} on {printable(topic)!s:.100}: the {part} encoded as {other!r:.40}, which is not read: ros1 "
                "and cdr are, and Foxglove’s scans, clouds, transforms and poses also in json and protobuf."
            )

    def _note_checksum(self, head: ChunkHead) -> None:
        self._note(f"The chunk at byte {head.at} has not the checksum that it states, and is left out.")

    def _note(self, sentence: str) -> None:
        if len(self.recording.notes) < 20:
            self.recording.notes.append(sentence)


def _damaged_chunk(at: int) -> str:
    return f"The chunk at byte {at} is damaged; its messages, or their rest, are left out."


def take_mcap(file: Source, recording: MessageSink, limits: Limits, progress: Progress | None) -> None:
    """Pass the contents of an MCAP file to ``recording``; for a cut or damaged file, the readable part.

    Raises :class:`ReadError` if nothing is readable, and :class:`LimitError`.
    """
    with byte_stream(file, limits, progress) as stream:
        mcap = _Mcap(stream, Transcoding(recording), limits)
        with opened(file) as raw:
            mcap.look_ahead(raw)
        mcap.read()
        recording.notes += stream.notes


MCAP = Container("MCAP", take_mcap)
