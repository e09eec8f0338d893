"""Memory shared by the workers of a service, created before they are forked."""

from __future__ import annotations

import secrets
from dataclasses import astuple, dataclass, fields
from hashlib import blake2b
from mmap import mmap

import numpy as np
from numpy.typing import NDArray

from server.sessions.registry import Use
from server.workers.shared_class import SharedClass

MAX_NETWORKS = 4096  #: number of networks whose wrong secrets are recorded
WAYS = 8  #: slots for a key among the counts
PLACES = 1 << 16  #: slots for networks among the connections
_ENTRY = np.dtype([("key", np.uint64), ("number", np.float64), ("at", np.float64)])


class SharedUse:
    """Each worker's use of the budgets: one row per worker, for processes that are forked later."""

    def __init__(self, workers: int) -> None:
        columns = len(fields(Use))
        memory = mmap(-1, workers * columns * 8)
        self._rows = np.frombuffer(memory, dtype=np.int64).reshape(workers, columns)

    def of(self, worker: int) -> WorkersUse:
        """Return the view of one worker."""
        return WorkersUse(self._rows, worker)

    def clear(self, worker: int) -> None:
        """Clear the use of a worker that has ended."""
        self._rows[worker] = 0


class WorkersUse:
    """The rows (workers, columns) as seen by worker ``own``."""

    def __init__(self, rows: NDArray[np.int64], own: int) -> None:
        self._rows, self._own = rows, own

    def others(self) -> Use:
        """Return the total use by the sessions of the other workers."""
        return Use(*(self._rows.sum(axis=0) - self._rows[self._own]).tolist())

    def state(self, own: Use) -> None:
        """Publish the use by the sessions of this worker."""
        self._rows[self._own] = astuple(own)


def keyed_hash(key: str, secret: bytes) -> int:
    """Return a hash of 8 bytes. Without the secret, nobody can choose keys that share a slot."""
    return int.from_bytes(blake2b(key.encode(), digest_size=8, key=secret).digest(), "little")


class SharedCounts:
    """About ``size`` numbers with a time, by key, shared by processes that are forked later.

    A key is stored as a keyed hash of 8 bytes in one of a few slots, as in a cache; if all are in use, the oldest entry
    is replaced. Of two workers that write simultaneously, one count may be lost.
    """

    def __init__(self, size: int) -> None:
        sets = -(-size // WAYS)
        memory = mmap(-1, sets * WAYS * _ENTRY.itemsize)
        self._entries = np.frombuffer(memory, dtype=_ENTRY).reshape(sets, WAYS)
        self._secret = secrets.token_bytes(16)

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and the time when it was set; 0 and 0 if there is none."""
        name, entries = self._places(key)
        rows = np.flatnonzero(entries["key"] == name)
        return (float(entries["number"][rows[0]]), float(entries["at"][rows[0]])) if len(rows) else (0.0, 0.0)

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key, replacing the oldest entry of its slots."""
        name, entries = self._places(key)
        rows = np.flatnonzero(entries["key"] == name)
        entries[int(rows[0]) if len(rows) else int(np.argmin(entries["at"]))] = (name, number, at)

    def _places(self, key: str) -> tuple[np.uint64, NDArray[np.void]]:
        name = keyed_hash(key, self._secret)
        return np.uint64(name), self._entries[name % len(self._entries)]


class SharedConnections:
    """Number of non-waiting connections of each worker, in total and for each network, like :class:`SharedUse`.

    A network is counted in one of many slots, by a keyed hash; two networks that share a slot count as one.
    """

    def __init__(self, workers: int) -> None:
        self._rows = np.frombuffer(mmap(-1, workers * (PLACES + 1) * 4), dtype=np.int32).reshape(workers, PLACES + 1)
        self._secret = secrets.token_bytes(16)

    def of(self, worker: int) -> WorkersConnections:
        """Return the view of one worker."""
        return WorkersConnections(self._rows, self._secret, worker)

    def clear(self, worker: int) -> None:
        """Clear the connections of a worker that has ended."""
        self._rows[worker] = 0


class WorkersConnections:
    """The rows (workers, slots and their sum) as seen by worker ``own``."""

    def __init__(self, rows: NDArray[np.int32], secret: bytes, own: int) -> None:
        self._rows, self._secret, self._own = rows, secret, own

    def others(self, network: str) -> tuple[int, int]:
        """Return the numbers of connections of the other workers: in total, and for a network."""
        columns = self._rows[:, [PLACES, self._place(network)]]
        in_all, of_network = columns.sum(axis=0) - columns[self._own]
        return int(in_all), int(of_network)

    def add(self, network: str, number: int) -> None:
        """Add ``number`` to the connections of a network in this worker."""
        self._rows[self._own, self._place(network)] += number
        self._rows[self._own, PLACES] += number

    def _place(self, network: str) -> int:
        return keyed_hash(network, self._secret) % PLACES


@dataclass(frozen=True, slots=True)
class Guesses:
    """Wrong secrets: tokens by network, codes of classes by visitor and by network."""

    tokens: SharedCounts
    codes_of_visitor: SharedCounts
    codes_of_network: SharedCounts

    @classmethod
    def make(cls) -> Guesses:
        """Allocate the memory."""
        return cls(*(SharedCounts(MAX_NETWORKS) for _ in range(3)))


@dataclass(frozen=True, slots=True)
class Shared:
    """The use of the budgets, the open connections, the wrong secrets, and the class that is open from the start.

    That class is None if there is none.
    """

    use: SharedUse
    connections: SharedConnections
    guesses: Guesses
    prepared: SharedClass | None

    @classmethod
    def make(cls, workers: int, class_code: str | None) -> Shared:
        """Allocate the memory for a number of workers."""
        prepared = None if class_code is None else SharedClass(class_code, workers)
        return cls(SharedUse(workers), SharedConnections(workers), Guesses.make(), prepared)

    def clear(self, worker: int) -> None:
        """Clear the data of a worker that has ended. The wrong secrets are kept."""
        self.use.clear(worker)
        self.connections.clear(worker)
        if self.prepared is not None:
            self.prepared.clear(worker)
