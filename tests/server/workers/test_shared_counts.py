"""Counts that processes share."""

from __future__ import annotations

import os

from server.workers.shared import WAYS, SharedCounts


def test_a_count_of_one_process_is_seen_by_another() -> None:
    counts = SharedCounts(64)
    assert counts.get("192.0.2.1") == (0.0, 0.0)
    child = os.fork()
    if not child:
        try:
            counts.set("192.0.2.1", 3.5, 100.0)
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    assert counts.get("192.0.2.1") == (3.5, 100.0)
    counts.set("192.0.2.1", 4.5, 101.0)
    assert counts.get("192.0.2.1") == (4.5, 101.0)
    assert counts.get("192.0.2.2") == (0.0, 0.0)


def test_the_oldest_count_makes_room() -> None:
    counts = SharedCounts(WAYS)  # one set: all keys share its places
    for i in range(WAYS + 1):
        counts.set(str(i), 1.0, 1.0 + i)
    assert counts.get("0") == (0.0, 0.0)
    assert [counts.get(str(i))[1] for i in range(1, WAYS + 1)] == [1.0 + i for i in range(1, WAYS + 1)]
