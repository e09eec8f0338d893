"""The result of one tick of a session's computation, for the event loop to send."""

from __future__ import annotations

from collections.abc import Callable
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


@dataclass(frozen=True, slots=True)
class QueuedCommand:
    """A command and the client that sent it (None: viser's panel, or code)."""

    command: Struct
    client: Client | None = None


@dataclass(slots=True)
class TickResult:
    """Collected on a worker thread, sent on the event loop."""

    client: Client | None = None  #: the sender of the command that is being carried out
    rest: list[QueuedCommand] = field(default_factory=list)  #: commands left for the next tick
    unfinished: Struct | None = None  #: the rest of a long command, for the next tick
    changed: bool = False  #: whether there is a new frame to publish
    is_new_hello: bool = False  #: whether ``hello`` says something else than before
    new_grid: bool = False  #: whether the whole layer of the map has to be updated
    box: CellBox | None = None  #: otherwise: the cells of the map that may have changed
    #: Those that may have changed in it, of each update ``row · cols + col``; None: any of the box.
    cells: list[NDArray[np.uint32]] | None = field(default_factory=list)
    cancelled: bool = False  #: whether a newer command cancelled the map, which is made in the next tick
    remade_ms: float | None = None  #: duration of recomputing the whole map
    slots: dict[str, Struct] = field(default_factory=dict)  #: newest message of each type, to all clients
    notices: list[NoticeMessage | ErrorMessage] = field(default_factory=list)  #: each sent to all clients
    answers: list[tuple[Client | None, Struct]] = field(default_factory=list)
    resent: list[tuple[Client | None, str]] = field(default_factory=list)  #: clients that get a slot's message again
    questions: dict[Client | None, Callable[[], None]] = field(default_factory=dict)  #: answered at the tick's end

    def add(self, change: Change) -> None:
        """Add what an update of the map changed."""
        self.changed = True
        self.new_grid = self.new_grid or change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box
            if change.cells is None:
                self.cells = None
            elif self.cells is not None:
                self.cells.append(change.cells)

    def slot(self, *messages: Struct) -> None:
        """Send messages to all clients, unless a newer one of its type replaces it first."""
        for message in messages:
            self.slots[type_of(message)] = message

    def notice(self, code: str, message: str) -> None:
        """Send a notice to all clients."""
        self.notices.append(NoticeMessage(code, message))

    def answer(self, message: Struct) -> None:
        """Send ``message`` to the sender of the present command."""
        self.answers.append((self.client, message))

    def refuse(self, client: Client | None, error: ProtocolError | MapperError) -> None:
        """Send ``client`` the reason why a command was refused."""
        self.answers.append((client, ErrorMessage(error.code, error.message)))
