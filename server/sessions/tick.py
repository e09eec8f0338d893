"""The commands that wait for a session's next tick, those that replace its map, and the result of a tick."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from msgspec import Struct

from mapper.core.errors import MapperError
from mapper.grid import CellBox
from server.stream.hub import Client
from server.stream.messages import ErrorMessage, NoticeMessage
from server.stream.protocol import ProtocolError, type_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mapper.mapping.integrate import Change


MAX_QUEUED = 256  #: most commands in the queue of a session,
MAX_QUEUED_OF_FOLLOWERS = 64  #: and additionally of a class's followers
#: After this time without a finished map, commands no longer cancel the computation, so that a map is shown.
MAX_CANCELLING_S = 1.5


@dataclass(frozen=True, slots=True)
class QueuedCommand:
    """A command and the client that sent it (None: viser's panel, or code)."""

    command: Struct
    client: Client | None = None


class CommandQueue:
    """The pending commands, first come, first served. Used from the event loop only."""

    def __init__(self) -> None:
        self._waiting: list[QueuedCommand] = []
        self._of_followers = 0  #: number of them sent by a class's followers
        self._added = 0
        self._is_closed = False
        self._shortened = asyncio.Event()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, command: Struct, client: Client | None = None) -> None:
        """Add a command of ``client``. Raises :class:`ProtocolError` if it has too many in the queue."""
        follows = client is not None and client.follows
        # A class's followers are counted separately, so that their questions never cause the lecturer's commands to be
        # refused.
        queued = self._of_followers if follows else len(self._waiting) - self._of_followers
        if queued >= (MAX_QUEUED_OF_FOLLOWERS if follows else MAX_QUEUED):
            raise ProtocolError("session.busy", "Too many commands are queued; this one was dropped.")
        self._waiting.append(QueuedCommand(command, client))
        self._of_followers += follows
        self._added += 1

    def waiting(self) -> list[QueuedCommand]:
        """Return the pending commands, oldest first."""
        return [*self._waiting]

    def finish(self, n: int, rest: Sequence[QueuedCommand]) -> None:
        """Record that the first ``n`` commands were carried out, except for ``rest``."""
        self._waiting[:n] = rest
        self._of_followers = sum(queued.client is not None and queued.client.follows for queued in self._waiting)
        self._notify()

    def close(self) -> None:
        """Record that no more commands will be carried out."""
        self._is_closed = True
        self._notify()

    def _notify(self) -> None:
        self._shortened.set()
        self._shortened = asyncio.Event()

    async def carried_out(self) -> None:
        """Wait until the currently queued commands have been carried out, or the queue is closed."""
        last = self._added
        while self._added - len(self._waiting) < last and not self._is_closed:
            await self._shortened.wait()


class ReplacingRequests:
    """The state of commands that replace the map. Fields are set on the event loop and read on any thread."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._is_cancellable = False  #: whether the current computation may be cancelled
        self._is_outdatable = False  #: whether a newer command that replaces the map may cancel it too
        self._is_cancelled = False  #: whether a client asked to cancel it
        self._queued = self._begun = 0  #: number of queued commands, and of those that were started
        self._since: float | None = None  #: arrival of the first one without a finished map

    def add(self) -> None:
        """Record that one was queued."""
        self._queued += 1
        self._since = self._clock() if self._since is None else self._since

    def cancel(self) -> None:
        """Record that a client asked to cancel the current computation."""
        self._is_cancelled = True

    def begin_tick(self) -> None:
        """Record the start of a computation for all queued commands."""
        self._begun = self._queued

    def accept_cancel(self) -> None:
        """Ignore an earlier ``cancel``, which concerned earlier computations."""
        self._is_cancelled = False

    def end_tick(self, *, was_cancelled: bool) -> None:
        """Record that the computation has ended."""
        if self._queued == self._begun:
            self._since = None
        elif not was_cancelled:
            self._since = self._clock()

    @contextmanager
    def cancellable(self, *, by_newer: bool = True) -> Iterator[None]:
        """Return a context in which ``cancel`` or a newer command cancels the computation (worker thread)."""
        self._is_cancellable, self._is_outdatable = True, by_newer
        try:
            yield
        finally:
            self._is_cancellable = False

    @property
    def is_useless(self) -> bool:
        """Whether the current computation should end (any thread)."""
        return self._is_cancellable and (self._is_cancelled or self._is_outdated())

    def _is_outdated(self) -> bool:
        since = self._since
        is_new = self._is_outdatable and self._queued > self._begun
        return is_new and since is not None and self._clock() - since < MAX_CANCELLING_S


@dataclass(slots=True)
class TickResult:
    """Collected on a worker thread, sent on the event loop."""

    client: Client | None = None  #: the sender of the current command
    rest: list[QueuedCommand] = field(default_factory=list)  #: commands left for the next tick
    unfinished: Struct | None = None  #: the rest of a long command, for the next tick
    changed: bool = False  #: whether there is a new frame to publish
    is_new_hello: bool = False  #: whether ``hello`` has changed
    new_grid: bool = False  #: whether the whole layer of the map has to be updated
    box: CellBox | None = None  #: otherwise: the cells of the map that may have changed
    #: Cells that may have changed in the box, for each update ``row · cols + col``; None: any cell of the box.
    cells: list[NDArray[np.uint32]] | None = field(default_factory=list)
    cancelled: bool = False  #: whether a newer command cancelled the map, which the next tick computes
    remade_ms: float | None = None  #: duration of recomputing the whole map
    slots: dict[str, Struct] = field(default_factory=dict)  #: newest message of each type, for all clients
    notices: list[NoticeMessage | ErrorMessage] = field(default_factory=list)  #: each is sent to all clients
    answers: list[tuple[Client | None, Struct]] = field(default_factory=list)
    resent: list[tuple[Client | None, str]] = field(default_factory=list)  #: clients that get a slot's message again
    questions: dict[Client | None, Callable[[], None]] = field(default_factory=dict)  #: answered at the end of the tick

    def add(self, change: Change) -> None:
        """Add the changes of a map update."""
        self.changed = True
        self.new_grid = self.new_grid or change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box
            if change.cells is None:
                self.cells = None
            elif self.cells is not None:
                self.cells.append(change.cells)

    def slot(self, *messages: Struct) -> None:
        """Send messages to all clients; a newer message of the same type replaces an unsent one."""
        for message in messages:
            self.slots[type_of(message)] = message

    def notice(self, code: str, message: str) -> None:
        """Send a notice to all clients."""
        self.notices.append(NoticeMessage(code, message))

    def answer(self, message: Struct) -> None:
        """Send ``message`` to the sender of the current command."""
        self.answers.append((self.client, message))

    def refuse(self, client: Client | None, error: ProtocolError | MapperError) -> None:
        """Send ``client`` the reason why a command was refused."""
        self.answers.append((client, ErrorMessage(error.code, error.message)))
