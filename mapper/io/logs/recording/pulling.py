"""Messages of some topics of a recording, one after another on demand.

The readers of containers push their messages, so one runs on a separate thread, which waits while :data:`AHEAD`
messages have not been consumed.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from queue import Full, Queue

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.inflate import ZSTD_MAGIC, inflate
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.names import printable
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros.ros_messages import plain_type

AHEAD = 2  #: messages read ahead
_LOOK_S = 0.2  #: between two checks whether the messages are still needed

Take = Callable[[Source, MessageSink, Limits, Progress | None], None]


@dataclass(frozen=True, slots=True)
class PulledMessage:
    """A message: its type, whether it is CDR, and its recording time."""

    stamp_ns: int
    type: str
    cdr: bool
    data: bytes


class _UnwantedError(Exception):
    """No more messages are needed."""


class _Pulled(MessageSink):
    """Puts the messages of one topic and type into a queue."""

    def __init__(self, topic: str, kind: str, limits: Limits, put: Callable[[PulledMessage], None]) -> None:
        self.notes = []
        self._taken = 0
        self._topic, self._kind, self._limits, self._put = topic, kind, limits, put
        self._known: dict[int, bool | None] = {}  #: key → whether it is CDR, None for other topics

    @property
    def taken(self) -> int:
        return self._taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        is_wanted = readable and printable(topic[:200]) == self._topic and plain_type(kind) == self._kind
        self._known[key] = cdr if is_wanted else None

    def knows(self, key: int) -> bool:
        return key in self._known

    def wants(self, key: int) -> bool:
        return self._known.get(key) is not None

    def pass_over(self, key: int, count: int) -> None:
        pass

    def next_file(self) -> None:
        self._known.clear()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:  # noqa: ARG002
        cdr = self._known.get(key)
        if cdr is None:
            return
        if data[:4] == ZSTD_MAGIC:  # rosbag2 can compress each message by itself
            try:
                data, _ = inflate("zstd", data, self._limits.max_chunk_bytes, "a message")
            except ReadError:
                return
        self._taken += 1
        self._put(PulledMessage(stamp_ns, self._kind, cdr, data))


def pulled(files: Sequence[Source], take: Take, topic: str, kind: str, limits: Limits) -> Iterator[PulledMessage]:
    """Yield the messages of one topic and type of the recording in ``files``.

    For a cut or damaged file, those that can be read. Raises the errors of reading the recording.
    """
    queue: Queue[PulledMessage | None] = Queue(AHEAD)
    closed = threading.Event()
    errors: list[Exception] = []

    def put(message: PulledMessage | None) -> None:
        while not closed.is_set():
            try:
                return queue.put(message, timeout=_LOOK_S)
            except Full:
                continue
        raise _UnwantedError

    def work() -> None:
        sink = _Pulled(topic, kind, limits, put)
        with contextlib.suppress(_UnwantedError):
            try:
                for file in files:
                    take(file, sink, limits, None)
                    sink.next_file()
            except _UnwantedError:
                raise
            except Exception as error:  # noqa: BLE001 - whatever it is, the thread that asks for messages raises it
                errors.append(error)
            put(None)

    thread = threading.Thread(target=work, name="pulled", daemon=True)
    thread.start()
    try:
        while (message := queue.get()) is not None:
            yield message
    finally:
        closed.set()
        thread.join()
    if errors:
        raise errors[0]
