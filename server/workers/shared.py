"""What the workers of a service share in memory: made before they are forked."""

from __future__ import annotations

from dataclasses import dataclass

from server.workers.shared_class import SharedClass
from server.workers.shared_connections import SharedConnections
from server.workers.shared_counts import MAX_NETWORKS, SharedCounts
from server.workers.use import SharedUse


@dataclass(frozen=True, slots=True)
class Guesses:
    """Wrong secrets: tokens by network, codes of classes by visitor and by network."""

    tokens: SharedCounts
    codes_of_visitor: SharedCounts
    codes_of_network: SharedCounts

    @classmethod
    def make(cls) -> Guesses:
        """Make the memory."""
        return cls(*(SharedCounts(MAX_NETWORKS) for _ in range(3)))


@dataclass(frozen=True, slots=True)
class Shared:
    """The use of the budgets, the open connections, the wrong secrets, and the class that is open from the start.

    That class is None for none.
    """

    use: SharedUse
    connections: SharedConnections
    guesses: Guesses
    prepared: SharedClass | None

    @classmethod
    def make(cls, workers: int, class_code: str | None) -> Shared:
        """Make the memory for so many workers."""
        prepared = None if class_code is None else SharedClass(class_code, workers)
        return cls(SharedUse(workers), SharedConnections(workers), Guesses.make(), prepared)

    def clear(self, worker: int) -> None:
        """Forget what a worker had, which has ended. The wrong secrets stay."""
        self.use.clear(worker)
        self.connections.clear(worker)
        if self.prepared is not None:
            self.prepared.clear(worker)
