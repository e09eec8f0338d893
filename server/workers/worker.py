"""One of several worker processes of a service."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass

from server.workers.handover import Channel, Handover
from server.workers.places import worker_of_class
from server.workers.shared import Guesses, Shared, WorkersConnections, WorkersUse
from server.workers.shared_class import WorkersClass

REPLACE = signal.SIGUSR1  #: makes a worker end once it has no running upload


@dataclass(frozen=True, slots=True)
class Worker:
    """Worker ``number`` of the service, counted from 0.

    ``alive`` is the reading end of a pipe whose other end only the supervisor has.
    """

    number: int
    handover: Handover
    use: WorkersUse
    connections: WorkersConnections
    guesses: Guesses
    prepared: WorkersClass | None
    alive: int

    @classmethod
    def of(cls, number: int, channels: Sequence[Channel], shared: Shared, alive: int) -> Worker:
        """Return a worker with the resources created for all of them."""
        prepared = None if shared.prepared is None else shared.prepared.of(number)
        handover = Handover(number, channels, shared.prepared)
        use, connections = shared.use.of(number), shared.connections.of(number)
        return cls(number, handover, use, connections, shared.guesses, prepared, alive)

    def has_class(self, code: str) -> bool:
        """Return whether requests with this code of a class reach this worker."""
        return worker_of_class(code, self.handover.workers) == self.number

    def end_with_supervisor(self) -> None:
        """Make this process end as by SIGTERM once the supervisor has ended, for whatever reason."""
        asyncio.get_running_loop().add_reader(self.alive, self._end)

    def _end(self) -> None:
        asyncio.get_running_loop().remove_reader(self.alive)
        os.kill(os.getpid(), signal.SIGTERM)
