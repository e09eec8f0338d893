"""Receivers of the messages of a recording, and two receivers for one pass."""

from __future__ import annotations

from typing import Protocol


class MessageSink(Protocol):
    """Takes a recording message by message, as the reader of its container hands them over.

    A stream of messages has a key, which is its own within one file of the recording.
    """

    notes: list[str]  #: one sentence each on what was noticed; a container's reader adds its own
    as_recorded: bool = False  #: whether messages are taken as they are, and none is made one of ROS

    @property
    def taken(self) -> int:
        """Number of messages taken so far; if it is not 0, something could be read."""

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages: ``kind`` is their type, ``cdr`` whether they are serialised as ROS 2 does.

        Messages that are not ``readable`` are of an unknown serialisation. Raises :class:`LimitError`.
        """

    def published_by(self, key: int, node: str) -> None:  # noqa: ARG002 - most sinks have no use for it
        """Take the name of the ``node`` that published a stream, which was announced; few recordings state it."""
        return

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced, so that chunks of it may be passed over unread."""

    def wants(self, key: int) -> bool:
        """Return whether anything is made of this stream's messages."""

    def pass_over(self, key: int, count: int) -> None:
        """Count messages of a stream of which nothing is made, and which were not read."""

    def next_file(self) -> None:
        """Go on with another file of the same recording, in which streams have keys of their own."""

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Take one message, recorded at ``stamp_ns``; one of a stream that was not announced is skipped.

        Of a stream that is not wanted, ``data`` may be left out and ``size`` say how many bytes there are. Raises
        :class:`LimitError`.
        """


class BothSinks(MessageSink):
    """Hands one pass over a recording to two sinks; what a container's reader notes is noted by the first."""

    def __init__(self, first: MessageSink, second: MessageSink) -> None:
        self.notes = first.notes
        self._first, self._both = first, (first, second)

    @property
    def taken(self) -> int:
        """Number of messages taken by the first."""
        return self._first.taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream to both."""
        for sink in self._both:
            sink.channel(key, topic, kind, cdr=cdr, readable=readable)

    def published_by(self, key: int, node: str) -> None:
        """Tell both who published a stream."""
        for sink in self._both:
            sink.published_by(key, node)

    def knows(self, key: int) -> bool:
        """Return whether both let chunks of the stream be passed over."""
        return all(sink.knows(key) for sink in self._both)

    def wants(self, key: int) -> bool:
        """Return whether one of them makes anything of the stream's messages."""
        return any(sink.wants(key) for sink in self._both)

    def pass_over(self, key: int, count: int) -> None:
        """Let both count messages that were not read."""
        for sink in self._both:
            sink.pass_over(key, count)

    def next_file(self) -> None:
        """Let both go on with another file."""
        for sink in self._both:
            sink.next_file()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Let both take a message."""
        for sink in self._both:
            sink.take(key, stamp_ns, data, size)
