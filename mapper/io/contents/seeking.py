"""The newest message of a topic at a time, and the first of each topic, found by reading as little as possible.

One chunk is read of an MCAP file with a summary or a ROS 1 bag with an index, and one row of an SQLite bag. Any other
recording is read from its beginning, skipping other topics.
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
    """A message, its type, whether it is CDR, and its recording time."""

    stamp_ns: int
    type: str
    cdr: bool
    data: bytes


@dataclass(frozen=True, slots=True)
class Stated:
    """How to read a topic's messages, as stated in the recording: encodings, and the definition of the type."""

    type: str
    message_encoding: str
    definition_encoding: str
    definition: bytes


class _PastError(Exception):
    """No more messages are needed."""


class _OfTopics(MessageSink):
    """Collects the messages of the topics selected by :meth:`is_wanted`."""

    def __init__(self, *, as_recorded: bool) -> None:
        self.notes = []
        self.as_recorded = as_recorded
        self._streams: dict[int, tuple[str, str, bool] | None] = {}  # topic, type and whether it is CDR

    @abstractmethod
    def is_wanted(self, topic: str) -> bool:
        """Return whether messages of a topic are needed now."""

    @abstractmethod
    def keep(self, topic: str, message: FoundMessage) -> None:
        """Store a message of a needed topic. Raises :class:`_PastError` if no more are needed."""

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages."""
        self._streams[key] = (printable(topic), plain_type(kind), cdr) if readable else None

    def wants(self, key: int) -> bool:
        """Return whether it is a stream of a needed topic."""
        stream = self._streams.get(key)
        return stream is not None and self.is_wanted(stream[0])

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return key in self._streams

    def pass_over(self, key: int, count: int) -> None:
        """Do nothing."""

    def next_file(self) -> None:
        """Forget the streams of the file."""
        self._streams.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        """Process one message. Raises :class:`_PastError` if no more are needed."""
        stream = self._streams.get(key)
        if stream is not None and self.is_wanted(stream[0]):
            topic, kind, cdr = stream
            self.keep(topic, FoundMessage(stamp_ns, kind, cdr, data))


class _Newest(_OfTopics):
    """Stores the newest message of a topic not later than a time, or the first if all are later."""

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
        """Store a message. Raises :class:`_PastError` for a later one, unless it is the first."""
        if message.stamp_ns > self._at_ns and self.found is not None:
            raise _PastError
        self.found = message


class _Firsts(_OfTopics):
    """Stores the first message of each of some topics."""

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
        """Store a message. Raises :class:`_PastError` with the last one."""
        self.found[topic] = message
        self._missing.discard(topic)
        if not self._missing:
            raise _PastError


def message_at(
    path: Path, topic: str, at_ns: int, limits: Limits = DEFAULT_LIMITS, *, as_recorded: bool = False
) -> FoundMessage:
    """Return the newest message of ``topic`` recorded at or before ``at_ns``; before the first, the first.

    Unless ``as_recorded``, which allows any serialisation, it is a ROS message, converted if necessary. Raises
    :class:`ReadError` if the recording has none, and the errors of reading it.
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
    """Return the first message of each of ``topics`` that has one, in one pass that ends when all are found.

    The messages are as recorded, see :func:`unpacked`. Raises the errors of reading the recording.
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
    """Return how to read the messages of each of ``topics``, as far as the recording at ``path`` states it.

    The parts of a split recording are read up to the one with the last of them. Raises the :class:`ReadError` of
    reading it.
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
        # Seeking by index goes back and forth, and back is slow there.
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
    """Return the newest message of ``topic`` at or before ``at_ns`` in a file read from its beginning.

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
    """Return a message decompressed, if it was compressed. Raises :class:`ReadError` for damaged data."""
    if message.data[:4] != ZSTD_MAGIC:  # rosbag2 can compress each message separately
        return message
    data, _ = inflate("zstd", message.data, limits.max_chunk_bytes, "a message")
    return FoundMessage(message.stamp_ns, message.type, message.cdr, data)
