"""ROS 1 bags, format 2.0, plain or compressed (bz2, lz4; the whole file gzip or Zstandard).

Source: wiki.ros.org/Bags/Format/2.0. After a line ``#ROSBAG V2.0`` come records: ``<header length> <header> <data
length> <data>``, a header being fields ``<length> name=value``; messages are in chunks, and their connections state
topic and type.

The records are read from front to back, without the index at the end: a bag whose recording was cut has none, and
what precedes the cut is still good. rosbags' reader needs the index, and expands a chunk without a cap; the
tests compare this one with it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archive import Source
from mapper.io.logs.bytestream import ByteStream, byte_stream
from mapper.io.logs.container import Container
from mapper.io.logs.inflate import inflate
from mapper.io.logs.recording import Recording
from mapper.io.logs.unpacking import Progress

MAGIC = b"#ROSBAG V"
VERSION = b"#ROSBAG V2.0\n"
MESSAGE, CHUNK, CONNECTION = b"\x02", b"\x05", b"\x07"
MAX_HEADER_BYTES = 1 << 20

_U32 = struct.Struct("<I")
_TIME = struct.Struct("<II")


class _CutError(Exception):
    """The data ends in the middle of a record."""


class _DamagedError(Exception):
    """The data is no record."""


def _fields(header: bytes) -> dict[bytes, bytes]:
    found = {}
    at = 0
    while at < len(header):
        if at + 4 > len(header):
            raise _DamagedError
        (size,) = _U32.unpack_from(header, at)
        at += 4
        name, equals, value = header[at : at + size].partition(b"=")
        if at + size > len(header) or not equals:
            raise _DamagedError
        found[name] = value
        at += size
    return found


def _records(data: bytes) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """Yield the records of a chunk. Raises :class:`_CutError` where it ends within one."""
    at = 0
    while at < len(data):
        if at + 4 > len(data):
            raise _CutError
        (size,) = _U32.unpack_from(data, at)
        body = at + 4 + size
        if body + 4 > len(data):
            raise _CutError
        header = data[at + 4 : body]
        (size,) = _U32.unpack_from(data, body)
        at = body + 4 + size
        if at > len(data):
            raise _CutError
        fields = _fields(header)
        if b"op" not in fields:
            raise _DamagedError
        yield fields, data[body + 4 : at]


class _Bag:
    def __init__(self, stream: ByteStream, recording: Recording, limits: Limits) -> None:
        self.stream = stream
        self.recording = recording
        self.limits = limits
        self.expanded = 0
        self.records = 0

    def read(self) -> None:
        """Hand everything to the recording that can be read; note what cannot."""
        if self.stream.read(len(VERSION)) != VERSION:
            raise ReadError("log.version", "The file is a ROS bag of another version than 2.0, the only one read here.")
        try:
            while self._record():
                pass
        except _CutError:
            self.recording.notes.append(
                f"The bag ends early, at byte {self.stream.at}, within a record: only what precedes is read."
            )
        except _DamagedError:
            self.recording.notes.append(f"The bag is damaged before byte {self.stream.at}: the rest is left out.")

    def _exactly(self, n: int) -> bytes:
        data = self.stream.read(n)
        if len(data) < n:
            raise _CutError
        return data

    def _record(self) -> bool:
        """Read one record; return whether there was one."""
        size = self.stream.read(4)
        if not size:
            return False
        if len(size) < 4:
            raise _CutError
        (n,) = _U32.unpack(size)
        if n > MAX_HEADER_BYTES:
            raise _DamagedError
        fields = _fields(self._exactly(n))
        (n,) = _U32.unpack(self._exactly(4))
        op = fields.get(b"op")
        if op is None:
            raise _DamagedError
        self._count_record()
        if op == CHUNK:
            at = self.stream.at
            data = self.stream.read(n)
            self._chunk(fields.get(b"compression", b"").decode("latin-1"), data, at, cut=len(data) < n)
            if len(data) < n:
                raise _CutError
        elif op in (CONNECTION, MESSAGE):
            self._content(fields, self._exactly(n))
        else:
            if fields.get(b"encryptor"):
                raise ReadError("log.encrypted", "The bag is encrypted.")
            if self.stream.skip(n) < n:
                raise _CutError
        return True

    def _chunk(self, compression: str, data: bytes, at: int, *, cut: bool) -> None:
        damaged = f"The chunk at byte {at} is damaged; its messages, or their rest, are left out."
        if compression in ("bz2", "lz4"):
            try:
                data, _ = inflate(compression, data, self.limits.max_chunk_bytes, f"the chunk at byte {at}")
            except ReadError:
                self._note(damaged)
                return
        elif compression != "none":
            self._note(f"The chunk at byte {at} is compressed in an unknown way, {compression!r:.40}, and is left out.")
            return
        self.expanded += len(data)
        if self.expanded > self.limits.max_log_bytes:
            raise LimitError(
                "log.too_many_bytes",
                f"The bag expands to more than the limit of {self.limits.max_log_bytes} bytes.",
            )
        try:
            for fields, content in _records(data):
                self._count_record()
                self._content(fields, content)
        except _DamagedError:
            self._note(damaged)
        except _CutError:
            if not cut:
                self._note(damaged)

    def _count_record(self) -> None:
        self.records += 1
        if self.records > self.limits.max_messages:
            raise LimitError("log.too_many_messages", f"The bag has more than {self.limits.max_messages} records.")

    def _content(self, fields: dict[bytes, bytes], content: bytes) -> None:
        """Take a connection or a message."""
        connection = fields.get(b"conn", b"")
        if len(connection) != 4:
            return
        (key,) = _U32.unpack(connection)
        if fields.get(b"op") == MESSAGE:
            time = fields.get(b"time", b"")
            seconds, nanoseconds = _TIME.unpack(time) if len(time) == 8 else (0, 0)
            self.recording.take(key, seconds * 1_000_000_000 + nanoseconds, content)
        elif fields.get(b"op") == CONNECTION:
            stated = _fields(content)
            topic, kind = (
                value.decode("utf-8", "replace")
                for value in (stated.get(b"topic", fields.get(b"topic", b"")), stated.get(b"type", b""))
            )
            self.recording.channel(key, topic, kind, cdr=False)

    def _note(self, sentence: str) -> None:
        if len(self.recording.notes) < 20:
            self.recording.notes.append(sentence)


def take_ros1_bag(file: Source, recording: Recording, limits: Limits, progress: Progress | None) -> None:
    """Hand what a bag holds over to ``recording``; of one that is cut or damaged, what could be read.

    Raises :class:`ReadError` for one of another version or encrypted, and :class:`LimitError`.
    """
    with byte_stream(file, limits, progress) as stream:
        _Bag(stream, recording, limits).read()
        recording.notes += stream.notes


ROS1_BAG = Container("ROS 1 bag", take_ros1_bag)
