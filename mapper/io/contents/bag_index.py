"""Look-up of one message in a ROS 1 bag through its index: only a chunk and the records after it are read.

Source: wiki.ros.org/Bags/Format/2.0. The end of the file has a record for each connection and each chunk. A chunk is
followed by a record for each of its connections, with the time of each message and its offset in the chunk's data.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.inflate import inflate
from mapper.io.logs.archives.unpacking import opened
from mapper.io.logs.containers.bag_records import (
    BAG_HEADER,
    CHUNK,
    CHUNK_INFO,
    CONNECTION,
    INDEX,
    MAX_FIRST_RECORD_BYTES,
    MESSAGE,
    U32,
    U64,
    VERSION,
    CutError,
    DamagedError,
    Fields,
    connection_of,
    fields_of,
    records,
    time_ns,
    topic_and_type,
)
from mapper.io.logs.names import printable

MAX_INDEX_BYTES = 1 << 26  #: of the records at the end of a bag
MAX_HEADER_BYTES = 1 << 12
MAX_ENTRIES = 1 << 20  #: of one connection in one chunk
_ENTRY = np.dtype([("seconds", "<u4"), ("nanoseconds", "<u4"), ("offset", "<u4")])
_COUNT = np.dtype([("connection", "<u4"), ("count", "<u4")])


@dataclass(frozen=True, slots=True)
class IndexedMessage:
    """A message of a bag: its recording time, type, and bytes."""

    stamp_ns: int
    type: str
    data: bytes


@dataclass(frozen=True, slots=True)
class _Chunk:
    at: int
    first_ns: int
    last_ns: int


def indexed_message(file: Source, topic: str, at_ns: int, limits: Limits) -> IndexedMessage | None:
    """Return the newest message of ``topic`` recorded at or before ``at_ns``; before the first, the first.

    None if the bag has no such message, or no index for it.
    """
    try:
        with opened(file) as stream:
            return _newest_message(stream, topic, at_ns, limits)
    except (CutError, DamagedError, StopIteration, KeyError, ReadError):
        return None


def definitions_in_bag(file: Source) -> dict[str, tuple[str, bytes]]:
    """Return type and definition of each topic's messages, from the index at the end of a bag."""
    definitions: dict[str, tuple[str, bytes]] = {}
    try:
        with opened(file) as stream:
            for fields, content in _index_records(stream):
                if fields[b"op"] == CONNECTION:
                    text = fields_of(content).get(b"message_definition", b"")
                    topic, kind = topic_and_type(fields, content)
                    if text:
                        definitions.setdefault(printable(topic), (kind, text))
    except (CutError, DamagedError, StopIteration, KeyError, ReadError):
        pass
    return definitions


def _newest_message(stream: BinaryIO, topic: str, at_ns: int, limits: Limits) -> IndexedMessage | None:
    kinds, chunks = _read_index(stream, topic)
    best: tuple[int, _Chunk, int, int] | None = None  # time, chunk, connection, offset
    earlier = sorted((chunk for chunk in chunks if chunk.first_ns <= at_ns), key=lambda chunk: -chunk.last_ns)
    for chunk in earlier:
        if best is not None and best[0] >= min(chunk.last_ns, at_ns):
            break
        for time, connection, offset in _entries(stream, chunk, kinds):
            if time <= at_ns and (best is None or time >= best[0]):
                best = (time, chunk, connection, offset)
    if best is None and chunks:
        chunk = min(chunks, key=lambda chunk: chunk.first_ns)
        first = min(_entries(stream, chunk, kinds), default=None)
        best = None if first is None else (first[0], chunk, first[1], first[2])
    if best is None:
        return None
    time, chunk, connection, offset = best
    return IndexedMessage(time, kinds[connection], _message(stream, chunk, connection, time, offset, limits))


def _index_records(stream: BinaryIO) -> Iterator[tuple[Fields, bytes]]:
    """Yield header and content of each record at the end of a bag."""
    start = stream.read(len(VERSION) + MAX_FIRST_RECORD_BYTES)
    if not start.startswith(VERSION):
        raise DamagedError
    fields, _ = next(records(start, len(VERSION)), ({}, b""))
    if fields.get(b"op") != BAG_HEADER or len(fields.get(b"index_pos", b"")) != 8:
        raise DamagedError
    (at,) = U64.unpack(fields[b"index_pos"])
    size = stream.seek(0, 2)
    if not len(VERSION) < at < size or size - at > MAX_INDEX_BYTES:
        raise DamagedError
    stream.seek(at)
    yield from records(stream.read(size - at))


def _read_index(stream: BinaryIO, topic: str) -> tuple[dict[int, str], list[_Chunk]]:
    """Return the type of each connection of a topic, and the chunks that have messages of one."""
    kinds: dict[int, str] = {}
    chunks = []
    for fields, content in _index_records(stream):
        if fields[b"op"] == CONNECTION:
            key = connection_of(fields)
            name, kind = topic_and_type(fields, content)
            if key is not None and printable(name) == topic:
                kinds[key] = kind
        elif fields[b"op"] == CHUNK_INFO and len(fields[b"chunk_pos"]) == 8 and len(content) % _COUNT.itemsize == 0:
            counts = np.frombuffer(content, _COUNT)
            if np.isin(counts["connection"], list(kinds)).any():
                (place,) = U64.unpack(fields[b"chunk_pos"])
                chunks.append(_Chunk(place, time_ns(fields[b"start_time"]), time_ns(fields[b"end_time"])))
    return kinds, chunks


def _record_head(stream: BinaryIO) -> tuple[Fields, int]:
    """Return the header of the next record, and the length of its data."""
    size = stream.read(4)
    if len(size) < 4 or U32.unpack(size)[0] > MAX_HEADER_BYTES:
        raise DamagedError
    (n,) = U32.unpack(size)
    head = stream.read(n + 4)
    if len(head) < n + 4:
        raise CutError
    return fields_of(head[:n]), int(U32.unpack_from(head, n)[0])


def _entries(stream: BinaryIO, chunk: _Chunk, kinds: dict[int, str]) -> Iterator[tuple[int, int, int]]:
    """Yield time, connection and offset of the messages of ``kinds`` in a chunk, from the records after it."""
    stream.seek(chunk.at)
    fields, n = _record_head(stream)
    if fields[b"op"] != CHUNK:
        raise DamagedError
    stream.seek(n, 1)
    while True:
        try:
            fields, n = _record_head(stream)
        except (CutError, DamagedError):  # the file ends
            return
        if fields.get(b"op") != INDEX:
            return
        key = connection_of(fields)
        if key not in kinds:
            stream.seek(n, 1)
            continue
        if n > MAX_ENTRIES * _ENTRY.itemsize or n % _ENTRY.itemsize:
            raise DamagedError
        for seconds, nanoseconds, offset in np.frombuffer(stream.read(n), _ENTRY).tolist():
            yield seconds * 1_000_000_000 + nanoseconds, int(key), offset


def _message(stream: BinaryIO, chunk: _Chunk, connection: int, time: int, offset: int, limits: Limits) -> bytes:
    stream.seek(chunk.at)
    fields, n = _record_head(stream)
    compression = fields[b"compression"].decode("latin-1")
    if compression == "none":
        stream.seek(offset, 1)
        fields, size = _record_head(stream)
        content = stream.read(min(size, n, limits.max_chunk_bytes))
        if len(content) < size:
            raise CutError
    else:
        if n > limits.max_chunk_bytes:
            raise DamagedError
        data, _ = inflate(compression, stream.read(n), limits.max_chunk_bytes, f"the chunk at byte {chunk.at}")
        fields, content = next(records(data, offset))
    if fields[b"op"] != MESSAGE or connection_of(fields) != connection or time_ns(fields[b"time"]) != time:
        raise DamagedError
    return content
