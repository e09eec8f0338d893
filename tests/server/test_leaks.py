"""Ended sessions leave no task, thread or file descriptor."""

from __future__ import annotations

import asyncio
import gc
import threading
from pathlib import Path

import pytest

from tests.server.service import Service, Watcher, eventually, running, settings_for


def descriptors() -> int:
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.is_dir() else 0


def threads() -> int:
    """Number of threads, without those of asyncio's own pools: on a busy machine a pool has more of them, all idle."""
    return sum(not thread.name.startswith("asyncio_") for thread in threading.enumerate())


def tasks(service: Service) -> list[str]:
    """Names of the tasks on the service's loop that belong to sessions and streams."""
    loop = service.state.sessions.loop
    names = (task.get_name() for task in asyncio.all_tasks(loop))
    return [name for name in names if name.startswith(("session world", "session log", "stream"))]


async def one_visit(service: Service, number: int) -> None:
    wanted = {"kind": "log", "log": "sample-office"} if number % 5 == 0 else {"kind": "simulation", "world": "room"}
    session_id = await asyncio.to_thread(lambda: service.begin(**wanted))
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.frames >= 2)
        await watcher.send("parameters", values={"window": 0.3})
    await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")


@pytest.mark.parametrize("visits", [12, pytest.param(50, marks=pytest.mark.long)])
async def test_many_visits_leave_nothing(tmp_path: Path, visits: int) -> None:
    with running(settings_for(tmp_path)) as service:
        for number in range(3):  # pools have their threads, caches their entries
            await one_visit(service, number)
        await eventually(lambda: not tasks(service))
        gc.collect()
        before, open_files = threads(), descriptors()
        for number in range(visits):
            await one_visit(service, number)
        await eventually(lambda: not tasks(service))
        assert service.state.sessions.all() == []
        # The pool of the sessions grows with what runs at one time, not with the number of visits.
        await eventually(lambda: threads() <= before + visits // 2)
        await eventually(lambda: descriptors() <= open_files + 2)
    gc.collect()


def test_a_service_that_ends_leaves_no_thread(tmp_path: Path) -> None:
    before = {thread.name for thread in threading.enumerate()}
    with running(settings_for(tmp_path)) as service:
        service.begin()
        assert any(thread.name.startswith("session") for thread in threading.enumerate())
    left = {thread.name for thread in threading.enumerate()} - before
    assert not [name for name in left if name.startswith(("session", "uvicorn"))]
