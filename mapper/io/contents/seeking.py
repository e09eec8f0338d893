"""The newest message of a topic at a moment, and the first of each, without reading what does not lead there.

Of an MCAP file with a summary and of a ROS 1 bag with an index one chunk is read; of an SQLite bag one row. Any other
recording is read from its beginning, in which other topics are jumped over.
"""

from __future__ import annotations

import contextlib
from abc import abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from mcap.reader import SeekingReader

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.bag_index import definitions_in_bag, indexed_message
from mapper.io.contents.definitions import MAX_BYTES
from mapper.io.logs.archives.archive import Member, Source
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress, opened, part_of
from mapper.io.logs.containers import mcap_file, ros1_bag, ros2_db3
from mapper.io.logs.containers.container import Container
from mapper.io.logs.names import printable
from mapper.io.logs.opening import parts_of
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros.ros_messages import plain_type


@dataclass(frozen=True, slots=True)
class FoundMessage:
    """A message, of which type it is, whether it is CDR, and when it was recorded."""

    stamp_ns: int
    type: str
    cdr: bool
    data: bytes


@dataclass(frozen=True, slots=True)
class Stated:
    """How the messages of a topic are to be read, as the recording says: encodings, and the definition of the type."""

    type: str
    message_encoding: str
    definition_encoding: str
    definition: bytes


class _PastError(Exception):
    """Nothing more is wanted."""


class _OfTopics(MessageSink):
    """Takes messages of the topics that it :meth:`is_wanted`."""

    def __init__(self, *, as_recorded: bool) -> None:
        self.notes = []
        self.as_recorded = as_recorded
        self._streams: dict[int, tuple[str, str, bool] | None] = {}  # topic, type and whether it is CDR

    @abstractmethod
    def is_wanted(self, topic: str) -> bool:
        """Return whether messages of a topic are taken now."""

    @abstractmethod
    def keep(self, topic: str, message: FoundMessage) -> None:
        """Take a message of a topic that is wanted. Raises :class:`_PastError` if nothing more is."""

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages."""
        self._streams[key] = (printable(topic), plain_type(kind), cdr) if readable else None

    def wants(self, key: int) -> bool:
        """Return whether it is a stream of a topic that is wanted."""
        stream = self._streams.get(key)
        return stream is not None and self.is_wanted(stream[0])

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return key in self._streams

    def pass_over(self, key: int, count: int) -> None:
        """Count nothing."""

    def next_file(self) -> None:
        """Forget the streams of the file."""
        self._streams.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        """Take one message. Raises :class:`_PastError` if nothing more is wanted."""
        stream = self._streams.get(key)
        if stream is not None and self.is_wanted(stream[0]):
            topic, kind, cdr = stream
            self.keep(topic, FoundMessage(stamp_ns, kind, cdr, data))


class _Newest(_OfTopics):
    """Keeps the newest message of a topic that is not later than a moment; where all are, the first."""

    def __init__(self, topic: str, at_ns: int, *, as_recorded: bool) -> None:
        super().__init__(as_recorded=as_recorded)
        self.found: FoundMessage | None = None
        self._topic, self._at_ns = topic, at_ns

    @property
    def taken(self) -> int:
        """Number of messages found."""
        return 0 if self.found is None else 1

    def is_wanted(self, topic: str) -> bool:
        """Return whether it is the topic."""
        return topic == self._topic

    def keep(self, topic: str, message: FoundMessage) -> None:  # noqa: ARG002 - there is one
        """Take a message. Raises :class:`_PastError` for one that is later than the moment and not the first."""
        if message.stamp_ns > self._at_ns and self.found is not None:
            raise _PastError
        self.found = message


class _Firsts(_OfTopics):
    """Keeps the first message of each of some topics."""

    def __init__(self, topics: Collection[str]) -> None:
        super().__init__(as_recorded=True)
        self.found: dict[str, FoundMessage] = {}
        self._missing = set(topics)

    @property
    def taken(self) -> int:
        """Number of messages found."""
        return len(self.found)

    def is_wanted(self, topic: str) -> bool:
        """Return whether there is no message of a topic yet."""
        return topic in self._missing

    def keep(self, topic: str, message: FoundMessage) -> None:
        """Take a message. Raises :class:`_PastError` with the last one."""
        self.found[topic] = message
        self._missing.discard(topic)
        if not self._missing:
            raise _PastError


def message_at(
    path: Path, topic: str, at_ns: int, limits: Limits = DEFAULT_LIMITS, *, as_recorded: bool = False
) -> FoundMessage:
    """Return the newest message of ``topic`` that was recorded at or before ``at_ns``; before the first, the first.

    Where it is not wanted ``as_recorded``, in any serialisation, it is one of ROS, or made one.
    Raises :class:`ReadError` where the recording has none, and as reading it does.
    """
    files, kind = parts_of(path, limits)
    if isinstance(kind, Container):
        first: FoundMessage | None = None
        for file in reversed(files):
            message = _found_in(file, kind, topic, at_ns, limits, as_recorded=as_recorded)
            if message is not None and message.stamp_ns <= at_ns:
                return unpacked(message, limits)
            first = message or first
        if first is not None:
            return unpacked(first, limits)
    raise no_messages(topic)


def no_messages(topic: str) -> ReadError:
    """Return the error that a recording has no messages on a topic."""
    return ReadError("contents.no_topic", f"The recording has no messages on {topic!r:.200}.")


def first_messages(
    path: Path, topics: Collection[str], limits: Limits = DEFAULT_LIMITS, progress: Progress | None = None
) -> dict[str, FoundMessage]:
    """Return the first message of each of ``topics`` that has one, in one pass, which ends when all are found.

    The messages are as they were recorded: see :func:`unpacked`.
    Raises as reading the recording does.
    """
    files, kind = parts_of(path, limits)
    if not isinstance(kind, Container):
        return {}
    firsts = _Firsts(topics)
    with contextlib.suppress(_PastError):
        for done, file in enumerate(files):
            kind.take(file, firsts, limits, part_of(progress, done, len(files)))
            firsts.next_file()
    return firsts.found


def stated_in(path: Path, topics: Collection[str], limits: Limits = DEFAULT_LIMITS) -> dict[str, Stated]:
    """Return how the recording at ``path`` says that messages are to be read, for each of ``topics`` of which it does.

    Of a recording in parts, those up to the one where the last of them is found are read.
    Raises :class:`ReadError` as reading it does.
    """
    files, kind = parts_of(path, limits)
    if not isinstance(kind, Container):
        return {}
    by_topic: dict[str, Stated] = {}
    for file in files:
        missing = set(topics) - set(by_topic)
        if not missing:
            break
        stated = _stated_in_file(file, kind, limits)
        by_topic |= {topic: stated[topic] for topic in missing & set(stated)}
    return by_topic


def _stated_in_file(file: Source, kind: Container, limits: Limits) -> dict[str, Stated]:
    if kind is mcap_file.MCAP:
        try:
            with opened(file) as stream:
                summary = SeekingReader(stream, record_size_limit=limits.max_chunk_bytes).get_summary()
        except Exception:  # noqa: BLE001 - whatever the library raises on a damaged file
            return {}
        by_topic: dict[str, Stated] = {}
        for channel in () if summary is None else summary.channels.values():
            schema = summary.schemas.get(channel.schema_id) if summary else None
            of = ("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data[: MAX_BYTES + 1])
            name, encoding, definition = of
            by_topic.setdefault(printable(channel.topic), Stated(name, channel.message_encoding, encoding, definition))
        return by_topic
    if kind is ros1_bag.ROS1_BAG:
        stated = definitions_in_bag(file)
        return {topic: Stated(name, "ros1", "ros1msg", text) for topic, (name, text) in stated.items()}
    if kind is ros2_db3.ROS2_DB3:
        rows = ros2_db3.definition_rows(file, limits)
        return {topic: Stated(name, "cdr", form, text.encode()) for topic, (name, form, text) in rows.items()}
    return {}


def _found_in(
    file: Source, kind: Container, topic: str, at_ns: int, limits: Limits, *, as_recorded: bool
) -> FoundMessage | None:
    if isinstance(file, Member) and file.unpacked is not None and kind is not ros2_db3.ROS2_DB3:
        # An index leads back and forth, and back is slow there.
        return read_up_to(file, kind, topic, at_ns, limits, as_recorded=as_recorded)
    if kind is mcap_file.MCAP:
        try:
            message_at = _by_index_of_mcap(file, topic, at_ns, limits, as_recorded=as_recorded)
        except Exception:  # noqa: BLE001 - whatever the library raises on a damaged file: it is read from its beginning
            message_at = None
        if message_at is not None:
            return message_at
    if kind is ros2_db3.ROS2_DB3:
        row = ros2_db3.newest_row(file, topic, at_ns, limits)
        return None if row is None else FoundMessage(row[0], plain_type(row[1]), True, row[2])
    if kind is ros1_bag.ROS1_BAG:
        message = indexed_message(file, topic, at_ns, limits)
        if message is not None:
            return FoundMessage(message.stamp_ns, plain_type(message.type), False, message.data)
    return read_up_to(file, kind, topic, at_ns, limits, as_recorded=as_recorded)


def read_up_to(
    file: Source, kind: Container, topic: str, at_ns: int, limits: Limits, *, as_recorded: bool = False
) -> FoundMessage | None:
    """Return the newest message of ``topic`` at or before ``at_ns`` of a file that is read from its beginning.

    ``as_recorded`` is as for :func:`message_at`.
    """
    newest = _Newest(topic, at_ns, as_recorded=as_recorded)
    with contextlib.suppress(_PastError):
        kind.take(file, newest, limits, None)
    return newest.found


def _by_index_of_mcap(
    file: Source, topic: str, at_ns: int, limits: Limits, *, as_recorded: bool
) -> FoundMessage | None:
    with opened(file) as stream:
        reader = SeekingReader(stream, record_size_limit=limits.max_chunk_bytes)
        summary = reader.get_summary()
        if summary is None or not summary.chunk_indexes:
            return None
        for backwards, end in ((True, at_ns), (False, None)):
            for schema, channel, message in reader.iter_messages(topics=[topic], ending_at=end, reverse=backwards):
                encoding = mcap_file.ENCODINGS.get(channel.message_encoding)
                if not as_recorded and (schema is None or encoding is None):
                    return None
                name = "" if schema is None else plain_type(schema.name)
                return FoundMessage(message.log_time, name, bool(encoding), message.data)
    return None


def unpacked(message: FoundMessage, limits: Limits) -> FoundMessage:
    """Return a message as it was before it was compressed, if it was. Raises :class:`ReadError` for damaged data."""
    if message.data[:4] != ZSTD_MAGIC:  # rosbag2 can compress each message by itself
        return message
    data, _ = inflate("zstd", message.data, limits.max_chunk_bytes, "a message")
    return FoundMessage(message.stamp_ns, message.type, message.cdr, data)
