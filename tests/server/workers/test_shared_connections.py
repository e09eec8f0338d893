"""Connections of all workers of a service count together."""

from __future__ import annotations

import os

from server.http.connections import Connections
from server.workers.shared import SharedConnections

HERE, THERE = "192.0.2.1", "192.0.2.2"


def test_connections_of_another_process_count() -> None:
    shared = SharedConnections(2)
    child = os.fork()
    if not child:
        status = 1
        try:
            there = Connections(10, 3, shared.of(1))
            if there.admit(5, HERE) and there.admit(6, HERE) and there.admit(7, THERE):
                status = 0
        finally:
            os._exit(status)
    assert os.waitpid(child, 0)[1] == 0
    here = Connections(10, 3, shared.of(0))
    assert shared.of(0).others(HERE) == (3, 2)
    assert [here.admit(descriptor, HERE) for descriptor in (5, 6)] == [True, False]  # with two elsewhere
    here.closed(5)
    assert here.admit(6, HERE)
    # What a worker has open does not count for itself a second time, nor once the worker has ended.
    assert shared.of(1).others(HERE) == (1, 1)
    shared.clear(1)
    assert [here.admit(descriptor, HERE) for descriptor in (7, 8, 9)] == [True, True, False]


def test_the_limit_of_the_service_is_that_of_all_workers() -> None:
    shared = SharedConnections(3)
    first, second = (Connections(4, 4, shared.of(worker)) for worker in (0, 1))
    assert [first.admit(n, f"192.0.2.{n}") for n in range(3)] == [True] * 3
    assert second.admit(1, "192.0.2.9")
    assert not second.admit(2, "192.0.2.10")
    assert not first.admit(4, "192.0.2.11")
    ended = []
    second.wait(1, lambda: ended.append(1))  # one that waits makes room
    assert second.admit(2, "192.0.2.10")
    assert ended == [1]


def test_idle_connections_of_a_worker_do_not_close_another() -> None:
    shared = SharedConnections(2)
    first, second = (Connections(3, 2, shared.of(worker)) for worker in (0, 1))
    for n, address in enumerate((HERE, HERE, THERE)):
        assert first.admit(n, address)
        first.wait(n, lambda: None)
        first.wait(n, lambda: None)  # after a request that was refused it waits still
    assert shared.of(1).others(HERE) == (0, 0)
    assert second.admit(1, HERE)
    first.work(0)  # a request of the same address
    first.work(0)
    assert shared.of(1).others(HERE) == (1, 1)
    assert not second.admit(2, HERE)
    first.closed(0)
    first.closed(1)
    assert shared.of(1).others(HERE) == (0, 0)
    assert second.admit(2, HERE)
