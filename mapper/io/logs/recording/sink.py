"""Receivers of a recording's messages, and a pair of receivers for one pass."""

from __future__ import annotations

from typing import Protocol


class MessageSink(Protocol):
    """Receives a recording message by message from the reader of its container.

    A stream of messages has a key that is unique within one file of the recording.
    """

    notes: list[str]  #: one remark per sentence; a container's reader adds its own
    as_recorded: bool = False  #: whether messages are received unchanged, without conversion to ROS

    @property
    def taken(self) -> int:
        """Number of messages so far; if not 0, something could be read."""

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of messages: ``kind`` is their type, ``cdr`` whether they use the serialisation of ROS 2.

        Messages that are not ``readable`` have an unknown serialisation. Raises :class:`LimitError`.
        """

    def published_by(self, key: int, node: str) -> None:  # noqa: ARG002 - most sinks have no use for it
        """Set the name of the ``node`` that published an announced stream; few recordings state it."""
        return

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced, so that its chunks may be skipped."""

    def wants(self, key: int) -> bool:
        """Return whether this stream's messages are used."""

    def pass_over(self, key: int, count: int) -> None:
        """Count unused messages of a stream, which were not read."""

    def next_file(self) -> None:
        """Continue with another file of the same recording, with its own stream keys."""

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Receive one message, recorded at ``stamp_ns``; one of an unannounced stream is skipped.

        For an unused stream, ``data`` may be omitted and ``size`` is its size in bytes. Raises :class:`LimitError`.
        """


class BothSinks(MessageSink):
    """Passes one pass over a recording on to two sinks; notes of a container's reader go to the first."""

    def __init__(self, first: MessageSink, second: MessageSink) -> None:
        self.notes = first.notes
        self._first, self._both = first, (first, second)

    @property
    def taken(self) -> int:
        """Number of messages received by the first."""
        return self._first.taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream to both."""
        for sink in self._both:
            sink.channel(key, topic, kind, cdr=cdr, readable=readable)

    def published_by(self, key: int, node: str) -> None:
        """Pass the publisher of a stream to both."""
        for sink in self._both:
            sink.published_by(key, node)

    def knows(self, key: int) -> bool:
        """Return whether both allow chunks of the stream to be skipped."""
        return all(sink.knows(key) for sink in self._both)

    def wants(self, key: int) -> bool:
        """Return whether one of them uses the stream's messages."""
        return any(sink.wants(key) for sink in self._both)

    def pass_over(self, key: int, count: int) -> None:
        """Count messages that were not read in both."""
        for sink in self._both:
            sink.pass_over(key, count)

    def next_file(self) -> None:
        """Continue with another file in both."""
        for sink in self._both:
            sink.next_file()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Pass a message to both."""
        for sink in self._both:
            sink.take(key, stamp_ns, data, size)
