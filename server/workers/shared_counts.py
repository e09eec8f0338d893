"""Numbers with a time, by key, in memory that the workers of a service share: the wrong secrets of each network.

A key is kept as a keyed hash of 8 bytes in one of a few places, as in a cache: where all are taken, the oldest entry
goes. Workers that write at once may lose one of two counts.
"""

from __future__ import annotations

import secrets
from hashlib import blake2b
from mmap import mmap

import numpy as np
from numpy.typing import NDArray

MAX_NETWORKS = 4096  #: of which wrong secrets are recorded
WAYS = 8  #: places of a key
_ENTRY = np.dtype([("key", np.uint64), ("number", np.float64), ("at", np.float64)])


def keyed_hash(key: str, secret: bytes) -> int:
    """Return a hash of 8 bytes: without the secret nobody chooses keys that share a place."""
    return int.from_bytes(blake2b(key.encode(), digest_size=8, key=secret).digest(), "little")


class SharedCounts:
    """At most about ``size`` numbers, shared by processes that are forked after this was made."""

    def __init__(self, size: int) -> None:
        sets = -(-size // WAYS)
        memory = mmap(-1, sets * WAYS * _ENTRY.itemsize)
        self._entries = np.frombuffer(memory, dtype=_ENTRY).reshape(sets, WAYS)
        self._secret = secrets.token_bytes(16)

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and the time when it was set; 0 and 0 for none."""
        name, entries = self._places(key)
        found = np.flatnonzero(entries["key"] == name)
        return (float(entries["number"][found[0]]), float(entries["at"][found[0]])) if len(found) else (0.0, 0.0)

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key, in the place of the oldest of those that share its places."""
        name, entries = self._places(key)
        found = np.flatnonzero(entries["key"] == name)
        entries[int(found[0]) if len(found) else int(np.argmin(entries["at"]))] = (name, number, at)

    def _places(self, key: str) -> tuple[np.uint64, NDArray[np.void]]:
        name = keyed_hash(key, self._secret)
        return np.uint64(name), self._entries[name % len(self._entries)]
