"""A client that looks seldom gets nothing older than its last looks, and a fast one beside it is undisturbed.

The exact statement, tick by tick on a clock of the test's own, is in tests/server/stream/test_hub.py; here real sockets
and real sessions show that nothing between the hub and the client (buffers, threads, the event loop) spoils it.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator

import pytest

from server.stream.grid_layer import GridLayer
from tests.server.service import Service, Watcher, eventually, running, settings_for

FRAMES = 5  #: that the fast client gets between two looks of the slow one
LOOKS = 10


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("load"))) as service:
        service.http.get("/readyz")
        yield service


async def drain(watcher: Watcher) -> int:
    """Read all that waits in the socket, a binary frame at least; return how many they are."""
    before = watcher.frames
    while watcher.frames == before:
        await watcher.read()
    while True:
        try:
            await watcher.read(0.02)
        except TimeoutError:
            return watcher.frames - before


async def test_a_slow_client_gets_the_newest_map_and_does_not_delay_a_fast_one(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="office", seed=1)
    async with service.connect(session_id) as slow_socket, service.connect(session_id) as fast_socket:
        slow, fast = Watcher(slow_socket), Watcher(fast_socket)
        looking = True

        async def keep_reading() -> None:
            while looking:
                if await fast.read() is None:
                    await fast.acknowledge()

        reading = asyncio.create_task(keep_reading())
        await drain(slow)
        await slow.acknowledge()
        looks = [time.monotonic()] * 2
        for _ in range(LOOKS):
            # The fast one goes on while the other reads nothing. It is the clock, so that a slow machine is none.
            seen = fast.frames
            await eventually(lambda seen=seen: fast.frames >= seen + FRAMES)  # type: ignore[misc]
            slow.ages.clear()
            assert await drain(slow) <= 2
            looks.append(time.monotonic())
            # What was on its way at the look before may have come after it.
            assert max(slow.ages) <= looks[-1] - looks[-3]
            await slow.acknowledge()
        looking = False
        await reading


async def test_a_client_that_never_reads_costs_the_others_nothing(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="office", seed=2)
    async with service.connect(session_id, max_queue=1, close_timeout=0.5), service.connect(session_id) as good_socket:
        good = Watcher(good_socket)
        await good.until(lambda: good.frames > 60)
        hub = service.state.sessions.get(session_id).hub
        assert max(client.unacknowledged for client in hub.clients) <= 2


async def test_twenty_browsers_on_ten_sessions_all_have_their_map(service: Service) -> None:
    worlds = ["office", "room", "loop", "hall", "maze"]
    http = service.http
    ids = []
    for i in range(10):
        if i % 5 == 0:
            http.cookies.clear()  # another visitor, with a budget of their own
        ids.append(service.begin(kind="simulation", world=worlds[i % 5], seed=i))

    all_run = asyncio.Barrier(20)

    async def watch(session_id: str) -> Watcher:
        async with service.connect(session_id) as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: watcher.frames > 20)
            await all_run.wait()
            await watcher.settle()
            return watcher

    watchers = await asyncio.gather(*(watch(ids[i % 10]) for i in range(20)))
    for i, watcher in enumerate(watchers):
        layer = service.state.sessions.get(ids[i % 10]).model.layers[0]
        assert isinstance(layer, GridLayer)
        assert layer.picture is not None
        assert watcher.picture.tobytes() == layer.picture.cells.tobytes()
