"""Prefetching of checkpoints in idle time, which a command interrupts."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.replay import checkpoints
from mapper.replay.replay import CheckpointPrefetcher
from mapper.sensors.scan import ScanLog
from server.sessions import SessionRegistry
from server.sessions import prefetching as preparing
from server.sessions.prefetching import CheckpointPrefetching
from tests.server.begin import new_log
from tests.server.service import eventually
from tests.server.view import view_of


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparing, "LOOK_EVERY_S", 0.001)
    monkeypatch.setattr(preparing, "PAUSE_S", 0.001)
    monkeypatch.setattr(checkpoints, "SPACING", 200_000)
    monkeypatch.setattr(checkpoints, "WORTH_KEEPING", 0)


def reached(session: Any) -> int:
    return int(session.model.recording.replay._replay.checkpoints.reached)


async def test_a_paused_log_is_prefetched_to_its_end(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(preparing, "QUIET_S", 0.0)
    await registry.start()
    session = await new_log(registry, "me", office_log, playing=False)
    client = session.join()
    await obey(session, type="seek", index=5)
    await eventually(lambda: reached(session) > 100)
    assert session.model.progress[0] == 5
    # With other parameters nothing of it holds, and it begins again.
    await obey(session, type="parameters", values={"log_odds_hit": 1.0})
    await eventually(lambda: reached(session) > 100)
    for index in (120, 30):
        await obey(session, type="seek", index=index)
        grid = OccupancyGrid(geometry_for(office_log, session.model.config))
        integrate_log(grid, office_log, session.model.config, stop=index)
        np.testing.assert_array_equal(view_of(session).log_odds, grid.log_odds)
    session.leave(client)


async def test_logs_without_a_client_are_not_prefetched(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(preparing, "QUIET_S", 0.0)
    await registry.start()
    session = await new_log(registry, "me", office_log, playing=False)
    await obey(session, type="seek", index=5)
    await asyncio.sleep(0.05)
    assert reached(session) == 5


class Steps(CheckpointPrefetcher):
    """A prefetcher that never ends, or fails."""

    def __init__(self, fault: Exception | None = None) -> None:
        self.fault, self.taken = fault, 0

    def step(self) -> bool:
        self.taken += 1
        if self.fault is not None:
            raise self.fault
        return True


@dataclass(eq=False)
class Watched:
    """A session as :class:`CheckpointPrefetching` sees it."""

    steps: Steps
    closed: bool = False
    commanded_at: float = 0.0
    watched: bool = True
    is_busy: bool = False
    cells: int = 1
    begun: int = 0

    def prefetcher(self) -> CheckpointPrefetcher:
        self.begun += 1
        return self.steps


async def test_room_is_asked_for_only_while_no_session_computes() -> None:
    # The answer takes a look at each session, and it would be asked for fifty times a second.
    looks, asked = 0, list[object]()
    one, other = Watched(Steps()), Watched(Steps(), is_busy=True)

    def sessions() -> list[Watched]:
        nonlocal looks
        looks += 1
        return [one, other]

    def is_room(session: object) -> bool:
        asked.append(session)
        return len(asked) < 4

    task = asyncio.create_task(CheckpointPrefetching(sessions, is_room, lambda: 10.0).run())
    await eventually(lambda: looks > 10)
    assert not asked
    other.is_busy = False
    other.closed = True
    await eventually(lambda: len(asked) > 4)
    assert one.steps.taken == 3  # one for each time that there was room
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


async def test_a_command_to_any_session_stops_it_and_only_quiet_lets_it_go_on() -> None:
    now = 10.0
    one, other = Watched(Steps()), Watched(Steps())
    task = asyncio.create_task(CheckpointPrefetching(lambda: [one, other], lambda _: True, lambda: now).run())
    await eventually(lambda: one.steps.taken > 3)
    assert other.steps.taken == 0  # one at a time
    other.is_busy = True
    taken = one.steps.taken + 1  # a step may be under way
    await asyncio.sleep(0.02)
    assert one.steps.taken <= taken
    other.is_busy = False
    await eventually(lambda: one.steps.taken > taken)
    one.commanded_at = now  # its turn is over until it is quiet
    await eventually(lambda: other.steps.taken > 3)
    taken = one.steps.taken + 1
    now += 2.0 * preparing.QUIET_S
    other.closed = True
    await eventually(lambda: one.steps.taken > taken)
    assert one.begun == 2  # begun again, from what is kept
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)


async def test_a_failure_or_lack_of_room_does_not_stop_other_prefetching() -> None:
    broken, large, good = Watched(Steps(MemoryError())), Watched(Steps(), cells=100), Watched(Steps())
    task = asyncio.create_task(
        CheckpointPrefetching(lambda: [broken, large, good], lambda one: one.cells < 50, lambda: 10.0).run()
    )
    await eventually(lambda: good.steps.taken > 3)
    assert (broken.steps.taken, large.steps.taken) == (1, 0)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
