"""How many connections that do not wait each worker of a service has, in all and of each network, in shared memory.

A network is counted in one of many places, by a keyed hash: two that share a place count as one.
"""

from __future__ import annotations

import secrets
from mmap import mmap

import numpy as np
from numpy.typing import NDArray

from server.workers.shared_counts import keyed_hash

PLACES = 1 << 16


class SharedConnections:
    """A row of counts for each worker, in memory that processes share which are forked after it was made."""

    def __init__(self, workers: int) -> None:
        self._rows = np.frombuffer(mmap(-1, workers * (PLACES + 1) * 4), dtype=np.int32).reshape(workers, PLACES + 1)
        self._secret = secrets.token_bytes(16)

    def of(self, worker: int) -> WorkersConnections:
        """Return the view of one worker."""
        return WorkersConnections(self._rows, self._secret, worker)

    def clear(self, worker: int) -> None:
        """Forget the connections of a worker that has ended."""
        self._rows[worker] = 0


class WorkersConnections:
    """The rows (workers, places and the sum of them) as worker ``own`` sees them."""

    def __init__(self, rows: NDArray[np.int32], secret: bytes, own: int) -> None:
        self._rows, self._secret, self._own = rows, secret, own

    def others(self, network: str) -> tuple[int, int]:
        """Return how many connections the other workers have: in all, and of a network."""
        columns = self._rows[:, [PLACES, self._place(network)]]
        in_all, of_network = columns.sum(axis=0) - columns[self._own]
        return int(in_all), int(of_network)

    def add(self, network: str, number: int) -> None:
        """Count so many more connections of a network in this worker."""
        self._rows[self._own, self._place(network)] += number
        self._rows[self._own, PLACES] += number

    def _place(self, network: str) -> int:
        return keyed_hash(network, self._secret) % PLACES
