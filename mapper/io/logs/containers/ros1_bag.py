"""ROS 1 bags, format 2.0, plain or compressed (bz2, lz4; the whole file gzip or Zstandard).

Source: wiki.ros.org/Bags/Format/2.0. After a line ``#ROSBAG V2.0`` come records: ``<header length> <header> <data
length> <data>``, with fields ``<length> name=value`` in the header; messages are in chunks, and their connections state
topic and type.

The records are read sequentially, without the index at the end, because a bag whose recording was cut has none, and the
data before the cut is still valid. rosbags' reader needs the index, and decompresses chunks without a cap; the tests
compare this one with it.

Only the data that a map needs is read from a plain file: large messages that are not used are skipped, also in plain
chunks, and so are compressed chunks that contain only such messages according to the indexes after them.
"""

from __future__ import annotations

import contextlib
import os
from typing import BinaryIO

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.bytestream import WORTH_A_JUMP, ByteStream, Section, byte_stream
from mapper.io.logs.archives.inflate import inflate
from mapper.io.logs.archives.unpacking import Progress, opened
from mapper.io.logs.containers.bag_records import (
    BAG_HEADER,
    CHUNK,
    CONNECTION,
    INDEX,
    MAX_FIRST_RECORD_BYTES,
    MESSAGE,
    U32,
    U64,
    VERSION,
    CutError,
    DamagedError,
    connection_of,
    fields_of,
    records,
    time_ns,
    topic_and_type,
)
from mapper.io.logs.containers.container import Container
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.recording.transcoding import Transcoding

MAGIC = b"#ROSBAG V"
MAX_HEADER_BYTES = 1 << 20
MAX_INDEX_BYTES = 1 << 24  #: for the connections at the end of a bag
MAX_INDEX_HEADER_BYTES = 1000  #: for an index record after a chunk
INDEX_ENTRY_BYTES = 12  #: a time and an offset


class _Bag:
    def __init__(self, stream: ByteStream, recording: MessageSink, limits: Limits) -> None:
        self.stream = stream
        self.recording = recording
        self.limits = limits
        self.knows_all_connections = False  #: whether the connections at the bag's end were read
        self.expanded = 0
        self.most_expanded = limits.unpacked_bytes(stream.file_size)
        self.records = 0
        self.most_records = limits.records(stream.file_size)

    def read(self) -> None:
        """Pass all readable messages to the recording; note what is unreadable."""
        if self.stream.read(len(VERSION)) != VERSION:
            raise ReadError(
                "log.version", "The file is a ROS bag of a version other than 2.0, the only one that is read."
            )
        try:
            while self._record():
                pass
        except CutError:
            self.recording.notes.append(
                f"The bag ends early, at byte {self.stream.at}, within a record: only what precedes is read."
            )
        except DamagedError:
            self.recording.notes.append(f"The bag is damaged before byte {self.stream.at}: the rest is left out.")

    def look_ahead(self, file: BinaryIO) -> None:
        """Read the connections repeated at the end of a complete, uncompressed bag.

        They are first in the chunks, so a damaged chunk would otherwise cost all later messages of its connections.
        Errors here are harmless, because the chunks repeat them.
        """
        start = file.read(len(VERSION) + MAX_FIRST_RECORD_BYTES)
        if not start.startswith(VERSION):
            return
        with contextlib.suppress(CutError, DamagedError, StopIteration):
            fields, _ = next(records(start[len(VERSION) :]))
            at = fields.get(b"index_pos", b"")
            if fields[b"op"] != BAG_HEADER or len(at) != 8:
                return
            (index_at,) = U64.unpack(at)
            size = file.seek(0, os.SEEK_END)
            if not len(VERSION) < index_at < size:
                return
            file.seek(index_at)
            for fields, content in records(file.read(min(size - index_at, MAX_INDEX_BYTES))):
                if fields[b"op"] != CONNECTION:
                    break
                self._content(fields, content)
            self.knows_all_connections = True

    def _exactly(self, source: ByteStream | Section, n: int) -> bytes:
        data = source.read(n)
        if len(data) < n:
            raise CutError
        return data

    def _head(self, source: ByteStream | Section, size: bytes) -> tuple[dict[bytes, bytes], int]:
        """Return a record's header, whose ``size`` has been read, and the length of its data."""
        (n,) = U32.unpack(size)
        if n > MAX_HEADER_BYTES:
            raise DamagedError
        fields = fields_of(self._exactly(source, n))
        (n,) = U32.unpack(self._exactly(source, 4))
        if b"op" not in fields:
            raise DamagedError
        self._count_record()
        return fields, n

    def _record(self) -> bool:
        """Read one record; return whether there was one."""
        size = self.stream.read(4)
        if not size:
            return False
        if len(size) < 4:
            raise CutError
        fields, n = self._head(self.stream, size)
        op = fields[b"op"]
        if op == CHUNK:
            self._chunk(fields.get(b"compression", b"").decode("latin-1"), n)
        elif op in (CONNECTION, MESSAGE):
            self._take_or_skip(self.stream, fields, n)
        else:
            if fields.get(b"encryptor"):
                raise ReadError("log.encrypted", "The bag is encrypted.")
            if op == INDEX:
                n = self._index_bytes(fields, n)
            if self.stream.skip(n) < n:
                raise CutError
        return True

    def _index_bytes(self, fields: dict[bytes, bytes], stated: int, ahead: int = 0) -> int:
        """Return the size of the entries of an index record, which start ``ahead`` bytes from here.

        rosbag reads as many entries as the header counts, and never the length before them, which recorders of 2010
        wrote wrongly. Here the length is ignored if the next record follows the entries, or if that cannot be checked.
        """
        count = fields.get(b"count", b"")
        if len(count) != 4 or fields.get(b"ver") != U32.pack(1):
            return stated
        counted = INDEX_ENTRY_BYTES * U32.unpack(count)[0]
        if counted == stated or (self.stream.can_jump and not self._is_record(ahead + counted)):
            return stated
        return int(counted)

    def _is_record(self, ahead: int) -> bool:
        """Return whether a record starts there, or the file ends."""
        size = self.stream.ahead(ahead, 4)
        if len(size) < 4:
            return not size
        (n,) = U32.unpack(size)
        try:
            return n <= MAX_INDEX_HEADER_BYTES and b"op" in fields_of(self.stream.ahead(ahead + 4, n))
        except DamagedError:
            return False

    def _take_or_skip(self, source: ByteStream | Section, fields: dict[bytes, bytes], n: int) -> None:
        """Process a record with ``n`` bytes of data; skip the data of a large unused message."""
        key = connection_of(fields)
        if fields[b"op"] == MESSAGE and n >= WORTH_A_JUMP and not (key is not None and self.recording.wants(key)):
            if source.skip(n) < n:
                raise CutError
            self._content(fields, b"", n)
        else:
            self._content(fields, self._exactly(source, n))

    def _chunk(self, compression: str, n: int) -> None:
        """Read a chunk of ``n`` bytes. Raises :class:`CutError` if the file ends in it."""
        at = self.stream.at
        if compression == "none" and self.stream.can_jump:
            self._plain_chunk(Section(self.stream, n), at)
            return
        if compression != "none" and self._skipped_by_index(n):
            return
        data = self.stream.read(n)
        self._chunk_data(compression, data, at, cut=len(data) < n)
        if len(data) < n:
            raise CutError

    def _plain_chunk(self, section: Section, at: int) -> None:
        """Read the used messages of an uncompressed chunk, whose data comes next."""
        try:
            while section.left:
                size = section.read(4)
                if len(size) < 4:
                    raise CutError
                self._take_or_skip(section, *self._head(section, size))
        except (CutError, DamagedError):
            section.skip(section.left)
            if section.left:
                raise CutError from None
            self._note(_damaged_chunk(at))

    def _skipped_by_index(self, n: int) -> bool:
        """Skip a compressed chunk of ``n`` bytes, and count its messages, if none of them is used.

        That is determined from the index records after it, one for each of its connections.
        """
        counts: dict[int, int] = {}
        ahead = n
        while self.knows_all_connections and (index := self._index_ahead(ahead)) is not None:
            key, count, record_bytes = index
            if self.recording.wants(key) or not self.recording.knows(key):
                return False
            counts[key] = count
            ahead += record_bytes
        if not counts:
            return False
        if self.stream.skip(n) < n:
            raise CutError
        for key, count in counts.items():
            self.recording.pass_over(key, count)
        return True

    def _index_ahead(self, ahead: int) -> tuple[int, int, int] | None:
        """Return connection, number of messages and size of an index record in the file; None if there is none."""
        size = self.stream.ahead(ahead, 4)
        if len(size) < 4 or U32.unpack(size)[0] > MAX_INDEX_HEADER_BYTES:
            return None
        (n,) = U32.unpack(size)
        record = self.stream.ahead(ahead + 4, n + 4)
        try:
            fields = fields_of(record[:n])
        except DamagedError:
            return None
        key, count = connection_of(fields), fields.get(b"count", b"")
        if len(record) < n + 4 or fields.get(b"op") != INDEX or key is None or len(count) != 4:
            return None
        entries = self._index_bytes(fields, U32.unpack_from(record, n)[0], ahead + n + 8)
        return key, U32.unpack(count)[0], n + 8 + entries

    def _chunk_data(self, compression: str, data: bytes, at: int, *, cut: bool) -> None:
        """Process the contents of a chunk's data, which is all that the file has of it."""
        if compression in ("bz2", "lz4"):
            try:
                data, _ = inflate(compression, data, self.limits.max_chunk_bytes, f"the chunk at byte {at}")
            except ReadError:
                self._note(_damaged_chunk(at))
                return
            self.expanded += len(data)
            if self.expanded > self.most_expanded:
                raise LimitError(
                    "log.too_many_bytes",
                    f"The bag’s chunks expand to more than the limit of {self.most_expanded} bytes.",
                )
        elif compression != "none":
            self._note(f"The chunk at byte {at} is compressed in an unknown way, {compression!r:.40}, and is left out.")
            return
        try:
            for fields, content in records(data):
                self._count_record()
                self._content(fields, content)
        except DamagedError:
            self._note(_damaged_chunk(at))
        except CutError:
            if not cut:
                self._note(_damaged_chunk(at))

    def _count_record(self) -> None:
        self.records += 1
        if self.records > self.most_records:
            raise LimitError("log.too_many_messages", f"The bag has more than {self.most_records} records.")

    def _content(self, fields: dict[bytes, bytes], content: bytes, size: int | None = None) -> None:
        """Process a connection or a message; ``size`` is its size if ``content`` was skipped."""
        key = connection_of(fields)
        if key is None:
            return
        if fields.get(b"op") == MESSAGE:
            self.recording.take(key, time_ns(fields.get(b"time", b"")), content, size)
        elif fields.get(b"op") == CONNECTION:
            topic, kind = topic_and_type(fields, content)
            self.recording.channel(key, topic, kind, cdr=False)
            self.recording.published_by(key, fields_of(content).get(b"callerid", b"").decode("utf-8", "replace"))

    def _note(self, sentence: str) -> None:
        if len(self.recording.notes) < 20:
            self.recording.notes.append(sentence)


def _damaged_chunk(at: int) -> str:
    return f"The chunk at byte {at} is damaged; its messages, or their rest, are left out."


def take_ros1_bag(file: Source, recording: MessageSink, limits: Limits, progress: Progress | None) -> None:
    """Pass the contents of a bag to ``recording``; for a cut or damaged bag, the readable part.

    Raises :class:`ReadError` for another version or an encrypted bag, and :class:`LimitError`.
    """
    with byte_stream(file, limits, progress) as stream:
        bag = _Bag(stream, Transcoding(recording), limits)
        with opened(file) as raw:
            bag.look_ahead(raw)
        bag.read()
        recording.notes += stream.notes


ROS1_BAG = Container("ROS 1 bag", take_ros1_bag)
