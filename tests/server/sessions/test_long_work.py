"""Long computations report their progress, yield their turn, and are cancelled when they are outdated."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.mapping import integrate
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.parts.costmap.part import CostmapPart
from server.parts.volume.part import VolumeView
from server.parts.wire import command_of
from server.sessions import SessionHost, SessionRegistry, computation, tick
from server.sources.simulation import SimulationModel
from tests.server.begin import between_ticks, new_log, new_simulation
from tests.server.service import PATIENCE_S, eventually
from tests.server.view import view_of


async def test_a_long_computation_shows_how_far_it_is_until_it_is_over(
    registry: SessionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(computation, "SHOWN_AFTER_S", 0.01)
    monkeypatch.setattr(computation, "SHOWN_EVERY_S", 0.01)
    released, remake = threading.Event(), SimulationModel._remake

    def slow(self: SimulationModel, *arguments: Any) -> None:
        self._mapper.fraction = 0.5
        assert released.wait(PATIENCE_S)
        remake(self, *arguments)

    monkeypatch.setattr(SimulationModel, "_remake", slow)
    session = await new_simulation(registry, "me", "room", seed=1, playing=False)
    client = session.join()
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.5}}))

    def working() -> dict[str, Any]:
        message: dict[str, Any] = json.loads(session.hub.slots.get("working", "{}"))
        return message

    await eventually(lambda: working().get("fraction") == 0.5)
    shown = [json.loads(message) for message in client.take() if isinstance(message, str)]
    assert [m["elapsed_s"] > 0.0 for m in shown if m["type"] == "working"] == [True]
    released.set()
    await eventually(lambda: working()["elapsed_s"] is None)
    assert session.model.config.window == 0.5


class Parts:
    """Counts the parts of which maps are made, and holds the first one until it is let go."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.windows: list[float] = []
        self.held, self.released = threading.Event(), threading.Event()
        monkeypatch.setattr("mapper.replay.replay.integrate_scans", self._integrate)
        monkeypatch.setattr("mapper.replay.replay.PART_READINGS", 3600)

    def _integrate(self, grid: Any, log: Any, config: Any, *more: Any) -> Any:
        self.windows.append(config.window)
        self.held.set()
        assert self.released.wait(PATIENCE_S)
        return integrate_scans(grid, log, config, *more)


async def test_newer_parameters_cancel_a_map(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tick, "MAX_CANCELLING_S", PATIENCE_S)  # a slow machine is late with the newer ones
    session = await new_log(registry, "me", office_log, playing=False)
    client = session.join()
    await obey(session, type="seek", index=office_log.n_scans)
    parts = Parts(monkeypatch)
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.41, "log_odds_hit": 1.5}}), client)
    await asyncio.to_thread(parts.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.42}}), client)
    parts.released.set()
    await eventually(lambda: session.model.config.window == 0.42)
    await between_ticks(session)
    assert parts.windows.count(0.41) == 1
    assert session.model.config.log_odds_hit == 1.5  # what the map given up was for is not lost
    whole = OccupancyGrid(geometry_for(office_log, session.model.config), session.model.config.log_odds_prior)
    integrate_log(whole, office_log, session.model.config)
    np.testing.assert_array_equal(view_of(session).log_odds, whole.log_odds)
    texts = [json.loads(message) for message in client.take() if isinstance(message, str)]
    assert "error" not in {message["type"] for message in texts}


async def test_continuous_commands_do_not_prevent_every_map_from_being_finished(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tick, "MAX_CANCELLING_S", 0.0)  # they have come for long
    session = await new_log(registry, "me", office_log, playing=False)
    await obey(session, type="seek", index=office_log.n_scans)
    parts = Parts(monkeypatch)
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.41}}))
    await asyncio.to_thread(parts.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.42}}))
    parts.released.set()
    await eventually(lambda: session.model.config.window == 0.42)
    assert parts.windows.count(0.41) == parts.windows.count(0.42) > 1


async def test_a_newer_seek_cancels_a_seek(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tick, "MAX_CANCELLING_S", PATIENCE_S)  # a slow machine is late with the newer one
    session = await new_log(registry, "me", office_log, playing=False)
    session.join()
    parts = Parts(monkeypatch)
    session.enqueue(command_of({"type": "seek", "index": office_log.n_scans}))
    await asyncio.to_thread(parts.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "seek", "index": 2}))
    parts.released.set()
    await obey(session, type="pause")
    await eventually(lambda: session.model.progress[0] == 2)
    assert len(parts.windows) < 10
    shown = session.model.layers[0].picture.cells != -128
    np.testing.assert_array_equal(shown, view_of(session).observed)


class Slices:
    """Lets a seek go on slice by slice, each of one part."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.allowed = threading.Semaphore(0)
        monkeypatch.setattr(computation, "SHOWN_AFTER_S", 0.0)
        monkeypatch.setattr("mapper.replay.replay.PART_READINGS", 3600)
        monkeypatch.setattr("server.sources.log.slice_is_over", lambda: self._over)

    def _over(self) -> bool:
        assert self.allowed.acquire(timeout=PATIENCE_S)
        return True


def whole_map(log: ScanLog, config: MappingConfig, count: int) -> OccupancyGrid:
    grid = OccupancyGrid(geometry_for(log, config), config.log_odds_prior)
    integrate_scans(grid, log, config, None, 0, count)
    return grid


async def test_a_long_seek_shows_the_map_on_the_way(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log, playing=False)
    session.join()
    slices = Slices(monkeypatch)
    session.enqueue(command_of({"type": "seek", "index": office_log.n_scans}))
    for _ in range(3):
        slices.allowed.release()
    shown = session.model.layers[0].picture.cells
    await eventually(lambda: bool((shown != -128).any()))
    assert 0 < session.model.progress[0] < office_log.n_scans
    await eventually(lambda: json.loads(session.hub.slots.get("working", "{}")).get("fraction") not in (None, 0.0))
    assert session.is_busy
    reading = asyncio.ensure_future(settled_index(session))
    for _ in range(office_log.n_scans):
        slices.allowed.release()
    assert await reading == office_log.n_scans  # who reads the map waits until it is whole
    await eventually(lambda: json.loads(session.hub.slots["working"])["elapsed_s"] is None)
    assert not session.is_busy
    view = view_of(session)
    np.testing.assert_array_equal(view.log_odds, whole_map(office_log, view.config, office_log.n_scans).log_odds)


async def settled_index(session: Any) -> int:
    async with session.settled():
        return int(session.model.progress[0])


async def test_a_long_seek_can_be_cancelled_where_it_is(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log, playing=False)
    session.join()
    slices = Slices(monkeypatch)
    session.enqueue(command_of({"type": "seek", "index": office_log.n_scans}))
    slices.allowed.release()
    await eventually(lambda: session.model.progress[0] > 0)
    session.enqueue(command_of({"type": "cancel"}))
    slices.allowed.release()
    index = await settled_index(session)
    assert 0 < index < office_log.n_scans
    view = view_of(session)
    np.testing.assert_array_equal(view.log_odds, whole_map(office_log, view.config, index).log_odds)


async def test_new_parameters_can_be_cancelled(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tick, "MAX_CANCELLING_S", 0.0)  # after which other commands end nothing
    session = await new_log(registry, "me", office_log, playing=False)
    client = session.join()
    await obey(session, type="seek", index=office_log.n_scans)
    before = view_of(session).log_odds.copy()
    client.take()
    parts = Parts(monkeypatch)
    session.enqueue(command_of({"type": "parameters", "values": {"window": 0.41}}), client)
    await asyncio.to_thread(parts.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "cancel"}), client)
    parts.released.set()
    await eventually(lambda: not session.has_queued_commands)
    await between_ticks(session)
    assert parts.windows == [0.41]
    assert session.model.config.window == 0.0
    np.testing.assert_array_equal(view_of(session).log_odds, before)
    texts = [json.loads(message) for message in client.take() if isinstance(message, str)]
    assert [m["values"]["window"] for m in texts if m["type"] == "parameters"] == [0.0]  # the page's slider goes back


async def test_the_progress_says_what_is_computed(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(computation, "SHOWN_AFTER_S", 0.01)
    released = threading.Event()

    def slow(*_: Any, **__: Any) -> None:
        assert released.wait(PATIENCE_S)

    monkeypatch.setattr(CostmapPart, "is_on", True)
    monkeypatch.setattr(CostmapPart, "changed", slow)
    monkeypatch.setattr(VolumeView, "handle", slow)
    monkeypatch.setattr(CostmapPart, "handle", slow)
    lab = await new_simulation(registry, "me", "room", seed=1, playing=False)
    log = await new_log(registry, "me", office_log, playing=False)
    for session, command, subject in (
        (lab, {"type": "map3d", "value": True}, "map_3d"),
        (lab, {"type": "teleport", "x": 2.0, "y": 2.0, "yaw": 0.0}, "costmap"),
        (log, {"type": "costmap"}, "costmap"),
    ):
        released.clear()
        session.enqueue(command_of(command))

        def is_told(session: SessionHost = session, subject: str = subject) -> bool:
            told = json.loads(session.hub.slots.get("working", "{}"))
            return told.get("elapsed_s") is not None and told["what"] == subject

        try:
            await eventually(is_told)
        finally:
            released.set()
        await between_ticks(session)


async def test_what_nobody_waits_for_stands_aside_for_a_long_seek(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log, playing=False)
    session.join()
    slices = Slices(monkeypatch)
    session.enqueue(command_of({"type": "seek", "index": office_log.n_scans}))
    await eventually(lambda: "working" in session.hub.slots)  # its progress is shown
    is_open = session.in_background()
    asked = asyncio.ensure_future(asyncio.to_thread(is_open))
    slices.allowed.release()
    await eventually(lambda: session.model.progress[0] > 0)
    assert not asked.done()
    session.enqueue(command_of({"type": "cancel"}))
    for _ in range(office_log.n_scans):
        slices.allowed.release()
    assert await asked is True


def test_a_long_map_is_computed_in_short_parts(office_log: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a clock that counts 5 ms for each scan no part is larger than the four scans that fill the time."""
    now, sizes = 0.0, []

    made = integrate._integration

    def counting(*given: Any) -> Any:
        add = made(*given)

        def counted(start: int, stop: int) -> Any:
            nonlocal now
            now += 0.005 * (stop - start)
            sizes.append(stop - start)
            return add(start, stop)

        return counted

    monkeypatch.setattr("time.thread_time", lambda: now)
    monkeypatch.setattr(integrate, "_integration", counting)
    config = MappingConfig(resolution=0.1)
    parts, whole = (OccupancyGrid(geometry_for(office_log, config)) for _ in range(2))
    reached = [at for at, _ in integrate.integrate_parts(parts, office_log, config, None, 0, 100)]
    assert max(sizes) == 4
    assert sizes[0] == 1
    assert reached[-1] == sum(sizes) == 100
    monkeypatch.undo()
    integrate_scans(whole, office_log, config, None, 0, 100)
    np.testing.assert_array_equal(parts.log_odds, whole.log_odds)
