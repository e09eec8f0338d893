"""Budgets: number of sessions, per visitor, size, idle time."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import LimitError
from mapper.sensors.scan import ScanLog
from server.parts.wire import command_of
from server.sessions import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sources.simulation import SimulationModel
from tests.server.begin import between_ticks, new_log, new_simulation
from tests.server.service import PATIENCE_S, eventually

Make = Callable[..., SessionRegistry]


async def test_idle_sessions_are_evicted_and_watched_ones_never(make_registry: Make, office_log: ScanLog) -> None:
    registry = make_registry(max_sessions=3, max_sessions_per_visitor=3)
    watched = await new_log(registry, "a", office_log)
    watched.join()
    oldest = await new_log(registry, "b", office_log)
    newer = await new_log(registry, "b", office_log)
    newest = await new_log(registry, "c", office_log)
    assert set(registry.all()) == {watched, newer, newest}
    assert oldest.closed
    newer.join()
    newest.join()
    with pytest.raises(SessionBudgetError) as refused:
        await new_log(registry, "d", office_log)
    assert refused.value.code == "session.full"
    assert set(registry.all()) == {watched, newer, newest}


async def test_one_visitors_budget_does_not_touch_anothers(make_registry: Make, office_log: ScanLog) -> None:
    registry = make_registry(max_sessions=10, max_sessions_per_visitor=2)
    theirs = await new_log(registry, "other", office_log)
    mine = [await new_log(registry, "me", office_log) for _ in range(4)]
    assert set(registry.all()) == {theirs, *mine[2:]}
    for session in mine[2:]:
        session.join()
    with pytest.raises(SessionBudgetError) as refused:
        await new_log(registry, "me", office_log)
    assert refused.value.code == "session.too_many"


async def test_sessions_created_concurrently_count_towards_the_limits(make_registry: Make, office_log: ScanLog) -> None:
    registry = make_registry(max_sessions=100, max_sessions_per_visitor=3)

    async def begin() -> Any:
        session = await new_log(registry, "me", office_log)
        session.join()
        return session

    results = await asyncio.gather(*(begin() for _ in range(8)), return_exceptions=True)
    assert len(registry) <= 3
    assert sum(isinstance(r, SessionBudgetError) for r in results) == 8 - len(registry)


async def test_idle_sessions_end_and_watched_ones_do_not(make_registry: Make, office_log: ScanLog) -> None:
    now = [0.0]
    registry = make_registry(session_idle_s=60.0, clock=lambda: now[0])
    idle, watched = [await new_log(registry, "me", office_log) for _ in range(2)]
    idle.unwatched_since = 0.0
    watched.join()
    now[0] = 59.0
    await registry.reap()
    assert len(registry) == 2
    now[0] = 61.0
    await registry.reap()
    assert registry.all() == [watched]
    with pytest.raises(SessionNotFoundError):
        registry.get(idle.id)


async def test_nobody_waits_for_the_last_computation_of_a_session_that_ends(
    registry: SessionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A kernel that is being compiled, for a minute on a busy machine, cannot be interrupted."""
    monkeypatch.setattr("server.sessions.registry.ENDING_S", 0.01)
    begun, compiled = threading.Event(), threading.Event()

    def slow(*_: Any) -> None:
        begun.set()
        assert compiled.wait(PATIENCE_S)

    session = await new_simulation(registry, "me", "room", 1)
    monkeypatch.setattr(SimulationModel, "advance", slow)
    session.join()
    await eventually(begun.is_set)
    try:
        await registry.close(session.id)
        with pytest.raises(SessionNotFoundError):
            registry.get(session.id)
    finally:
        compiled.set()
    await registry.shutdown()


async def test_all_grids_together_are_bounded(make_registry: Make, office_log: ScanLog) -> None:
    size = (await new_log(make_registry(), "me", office_log)).cells
    registry = make_registry(max_cells=2 * size, max_total_cells=int(2.5 * size))
    idle = await new_log(registry, "me", office_log)
    first = await new_log(registry, "me", office_log)
    assert idle.closed  # nobody watched it, and a large grid might have needed its room
    first.join()
    second = await new_log(registry, "you", office_log)
    second.join()
    third = await new_log(registry, "they", office_log)
    assert (first.model.config.resolution, second.model.config.resolution) == (0.05, 0.05)
    assert third.model.config.resolution > 0.05  # what room is left is for a coarser map
    third.join()
    assert sum(s.cells for s in registry.all()) <= 2.5 * size
    third.enqueue(command_of({"type": "parameters", "values": {"resolution": 0.05}}))
    await eventually(lambda: not third.has_queued_commands)
    await between_ticks(third)
    assert sum(s.cells for s in registry.all()) <= 2.5 * size


async def test_the_logs_of_all_sessions_together_are_bounded(make_registry: Make, office_log: ScanLog) -> None:
    def another() -> ScanLog:
        return replace(office_log, ranges=np.tile(office_log.ranges, (1, 5)))

    registry = make_registry(max_log_bytes=2 * another().ranges.nbytes)
    shared = another()
    first = await new_log(registry, "me", shared)
    first.join()
    second = await new_log(registry, "you", another())
    again = await new_log(registry, "me", shared)  # its readings are in memory already
    assert set(registry.all()) == {first, second, again}
    third = await new_log(registry, "they", another())
    assert set(registry.all()) == {first, again, third}
    third.join()
    with pytest.raises(SessionBudgetError) as refused:
        await new_log(registry, "we", another())
    assert refused.value.code == "session.memory"
    with pytest.raises(LimitError, match="more memory than the server has"):
        await new_log(registry, "me", replace(office_log, ranges=np.tile(office_log.ranges, (1, 20))))
    assert {first, again, third} == set(registry.all())


async def test_one_visitor_has_half_of_the_cells_and_of_the_memory_for_logs(
    make_registry: Make, office_log: ScanLog
) -> None:
    size = (await new_log(make_registry(), "me", office_log)).cells
    registry = make_registry(max_cells=size, max_total_cells=6 * size)
    theirs = await new_log(registry, "you", office_log)
    for _ in range(3):
        (await new_log(registry, "me", office_log)).join()
    with pytest.raises(SessionBudgetError, match="all cells of the service, or all that one visitor may have"):
        await new_log(registry, "me", office_log)
    assert not theirs.closed, "nobody watches it, but to end it would make no room"
    assert (await new_log(registry, "you", office_log)).model.config.resolution == 0.05

    def another() -> ScanLog:
        return replace(office_log, ranges=np.tile(office_log.ranges, (1, 5)))

    registry = make_registry(max_log_bytes=4 * another().ranges.nbytes)
    for _ in range(2):
        (await new_log(registry, "me", another())).join()
    with pytest.raises(SessionBudgetError, match="memory that one visitor may have") as refused:
        await new_log(registry, "me", another())
    assert refused.value.code == "session.memory"
    await new_log(registry, "you", another())


async def test_ids_cannot_be_guessed(registry: SessionRegistry, office_log: ScanLog) -> None:
    ids = {(await new_log(registry, "me", office_log)).id for _ in range(5)}
    assert len(ids) == 5
    assert all(len(session_id) >= 24 for session_id in ids)


async def test_an_unknown_session_is_refused(registry: SessionRegistry) -> None:
    with pytest.raises(SessionNotFoundError):
        registry.get("x")
    with pytest.raises(SessionNotFoundError):
        await registry.close("x")


async def test_guests_have_half_of_the_cells_and_end_no_session_of_others(
    make_registry: Callable[..., SessionRegistry], office_log: ScanLog
) -> None:
    first = await new_log(make_registry(), "owner", office_log)
    registry = make_registry(max_cells=2 * first.cells, max_total_cells=4 * first.cells)
    owner = await new_log(registry, "owner", office_log)
    guest = await new_log(registry, "guest", office_log, link="a link")
    assert registry.limits(owner).max_cells == registry.limits(guest).max_cells == 2 * first.cells
    assert registry.limits(None).max_cells == 2 * first.cells
    other = await new_log(registry, "other", office_log, link="another link")
    # The guest who left made room, the owner, who left too, did not.
    assert registry.all() == [owner, other]
    watched = other.join()
    third = await new_log(registry, "third", office_log, link="another link")
    assert registry.limits(third).max_cells == first.cells
    other.leave(watched)
