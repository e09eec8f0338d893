"""Turns that wait, by owner: with hundreds of them the next one is found without a look at each."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from server.work.scheduler import JobOwner, Turn


class WaitingTurns:
    """The waiting turns of each owner, the one that has waited longest first."""

    def __init__(self) -> None:
        self._queues: dict[JobOwner, deque[Turn]] = {}

    def __bool__(self) -> bool:
        return bool(self._queues)

    def __contains__(self, turn: Turn) -> bool:
        return turn in self._queues.get(turn.owner, ())

    def add(self, turn: Turn) -> None:
        """Add a turn, which has waited for the shortest time."""
        self._queues.setdefault(turn.owner, deque()).append(turn)

    def remove(self, turn: Turn) -> None:
        """Remove a turn. Raises :class:`ValueError` if it does not wait."""
        queue = self._queues.get(turn.owner, deque())
        queue.remove(turn)
        if not queue:
            del self._queues[turn.owner]

    def owners(self) -> list[JobOwner]:
        """Return the owners of the turns."""
        return list(self._queues)

    def firsts(self) -> list[Turn]:
        """Return the turn of each owner that has waited longest."""
        return [queue[0] for queue in self._queues.values()]
