"""The commands that a session has not carried out yet, first come, first served."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from msgspec import Struct

from server.sessions.tick import QueuedCommand
from server.stream.hub import Client
from server.stream.protocol import ProtocolError

MAX_QUEUED = 256  #: most commands in the queue of a session,
MAX_QUEUED_OF_FOLLOWERS = 64  #: and of a class's followers besides


class CommandQueue:
    """Used from the event loop only."""

    def __init__(self) -> None:
        self._waiting: list[QueuedCommand] = []
        self._added = 0
        self._is_closed = False
        self._shortened = asyncio.Event()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, command: Struct, client: Client | None = None) -> None:
        """Add a command of ``client``. Raises :class:`ProtocolError` if it has too many in the queue."""
        if self._is_full(client):
            raise ProtocolError("session.busy", "Too many commands are queued; this one was dropped.")
        self._waiting.append(QueuedCommand(command, client))
        self._added += 1

    def _is_full(self, client: Client | None) -> bool:
        # Those of a class's followers are counted apart: their questions must not have the lecturer's commands refused.
        follows = client is not None and client.follows
        queued = sum((one.client is not None and one.client.follows) == follows for one in self._waiting)
        return queued >= (MAX_QUEUED_OF_FOLLOWERS if follows else MAX_QUEUED)

    def waiting(self) -> list[QueuedCommand]:
        """Return the commands that wait, oldest first."""
        return [*self._waiting]

    def finish(self, n: int, rest: Sequence[QueuedCommand]) -> None:
        """Note that the first ``n`` commands were carried out, except for ``rest``."""
        self._waiting[:n] = rest
        self._notify()

    def close(self) -> None:
        """Note that no command will be carried out any more."""
        self._is_closed = True
        self._notify()

    def _notify(self) -> None:
        self._shortened.set()
        self._shortened = asyncio.Event()

    async def carried_out(self) -> None:
        """Wait until the commands that are in the queue now have been carried out, or the queue is closed."""
        last = self._added
        while self._added - len(self._waiting) < last and not self._is_closed:
            await self._shortened.wait()
