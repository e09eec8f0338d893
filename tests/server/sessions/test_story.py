"""Stories are replayed in slices, at an estimated cost, and only while their client is connected."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
from collections.abc import Callable
from http.client import HTTPConnection
from typing import Any

import httpx
import numpy as np
import pytest

from mapper.core.errors import LimitError, WorkCancelledError
from mapper.simulation import WORLDS
from mapper.simulation.live_map import LiveMap
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.tick import TickResult
from server.sources import simulation_replay
from server.sources.history import History, Replayable, SimulationHistory
from server.sources.simulation_replay import act, check_cost, history_of, replay_seconds, replayed
from server.stream.commands import AutoCommand, EditCommand, SensorCommand, TeleportCommand
from server.stream.message_parts import DrawnSolid
from tests.server.begin import new_simulation
from tests.server.service import PATIENCE_S, Service, eventually, running, settings_for, until

BOX: DrawnSolid = ("box", 300, 300, 340, 340)


def edits(count: int, every: int = 2) -> SimulationHistory:
    """A history of so many edits, each of another box; every world has walked for 100 steps before the first."""
    journal = [
        [100 + every * i, {"type": "edit", "added": [["box", 300 + i, 300, 340 + i, 340]], "erased": []}]
        for i in range(count)
    ]
    fields = {"world": "room", "seed": 1, "journal": journal, "steps": 100 + every * count}
    return SimulationHistory.model_validate(fields)


def test_a_story_of_many_edits_is_replayed_in_short_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two questions whether it is wanted there is one edit, one step, or one part of the map."""
    done: list[str] = []
    advance = LiveMap.advance

    def edit(*arguments: Any) -> None:
        done.append("edit")
        act(*arguments)

    def step(self: LiveMap, dt: float) -> Any:
        done.append("step")
        return advance(self, dt)

    monkeypatch.setattr(simulation_replay, "act", edit)
    monkeypatch.setattr(LiveMap, "advance", step)
    asked = []

    def wanted() -> bool:
        asked.append(tuple(done))
        done.clear()
        return True

    replayed(edits(30), may_continue=wanted)
    assert max(len(slice_) for slice_ in asked[1:]) == 1  # the first holds the two seconds of every world's beginning
    assert sum(slice_.count("edit") for slice_ in asked) == 30


@pytest.mark.parametrize("at", [0, 10, 60, 100])
def test_a_story_that_is_not_wanted_any_more_ends(at: int) -> None:
    asked = 0

    def wanted() -> bool:
        nonlocal asked
        asked += 1
        return asked <= at

    with pytest.raises(WorkCancelledError):
        replayed(edits(30), may_continue=wanted)
    assert asked <= at + 30  # those of the world's beginning, whose time passes in any case


def test_the_map_that_is_made_at_the_end_is_the_one_that_grew_scan_by_scan() -> None:
    live = LiveMap(WORLDS["room"], 5)
    acts = (
        TeleportCommand(6.0, 6.2),
        SensorCommand({"n_beams": 90}),
        EditCommand([BOX], [9]),
        SensorCommand({"kind": "sonar_ring"}),
        AutoCommand(value=True),
    )
    for command in acts:
        act(live, command, TickResult())
        live.advance(1.3)
    told = replayed(SimulationHistory.model_validate_json(history_of(live).model_dump_json()))
    assert told.config == live.config
    assert told.grid.geometry == live.grid.geometry
    np.testing.assert_array_equal(told.grid.log_odds, live.grid.log_odds)
    np.testing.assert_array_equal(told.grid.observed, live.grid.observed)
    for mapper in (told, live):
        mapper.advance(0.5)
    np.testing.assert_array_equal(told.grid.log_odds, live.grid.log_odds)


def test_a_story_costs_more_the_more_happens_in_it() -> None:
    cost = replay_seconds(History(steps=10_000))
    assert cost > replay_seconds(History(steps=5000))
    assert replay_seconds(History(steps=10_000, sensor={"n_beams": 1080, "scan_rate": 25})) > 2 * cost
    sonar = SensorCommand({"kind": "sonar_ring", "n_sonars": 48, "beam_width": 1.0, "scan_rate": 25})
    early, late = (History(steps=10_000, journal=[(at, sonar)]) for at in (0, 9000))
    assert replay_seconds(early) > replay_seconds(late) > cost
    assert replay_seconds(edits(900)) > 10 * replay_seconds(edits(30))
    one, many = (History(journal=[(0, EditCommand([BOX] * count))]) for count in (1, 100))
    assert replay_seconds(many) > replay_seconds(one)


@pytest.mark.parametrize("sensor", [{}, {"n_beams": "x"}, {"beams": 4}])
def test_the_cost_with_a_sensor_that_there_is_not_is_a_number(sensor: dict[str, Any]) -> None:
    assert replay_seconds(History(sensor=sensor)) == replay_seconds(History())


async def test_a_story_contains_what_was_asked_of_the_session_before(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", 1, playing=False)
    session.enqueue(command_of({"type": "faults", "values": {"drift": True}}))
    replayable = session.model.find(Replayable)
    assert (await replayable.present_history()).faults == {"drift": True}
    session.enqueue(command_of({"type": "step", "scans": 30}))  # in three ticks
    session.enqueue(command_of({"type": "play"}))
    closing = asyncio.create_task(replayable.present_history())
    await registry.close(session.id)
    assert (await closing).world == "room"  # of a session that has ended nothing is waited for


async def test_a_story_that_would_take_too_long_is_refused_before_it_begins(
    registry: SessionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.sources.simulation_replay.replayed", lambda *_, **__: pytest.fail("it began"))
    with pytest.raises(LimitError, match=r"about 8 s of computing, more than the 2 s .* GRIDBLOOM_MAX_STORY_S"):
        await new_simulation(registry, "me", "room", 1, edits(900), max_story_s=2.0)
    assert len(registry) == 0


def test_the_story_of_a_long_simulation_can_be_opened() -> None:
    """The service opens the stories that it writes: where the whole is too costly, that is the present state."""
    mapper = LiveMap(WORLDS["room"], 3)
    for i in range(20):
        mapper.journal.append((i, EditCommand([BOX])))
    cost = replay_seconds(history_of(mapper))
    assert history_of(mapper, max_s=1.01 * cost).journal is not None
    short = history_of(mapper, max_s=0.99 * cost)
    assert short.journal is None
    check_cost(short, 0.99 * cost)


async def test_replaying_a_story_ends_when_its_client_disconnects(registry: SessionRegistry) -> None:
    task = asyncio.ensure_future(new_simulation(registry, "me", "room", 1, edits(900, every=30), name="mine"))
    await eventually(lambda: not registry.under_way.is_empty)
    making = registry.under_way.get("me", "mine")
    assert making is not None
    await eventually(lambda: making.fraction > 0.0)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    assert not making.is_wanted
    # The turn is free again: somebody else's world begins.
    await asyncio.wait_for(new_simulation(registry, "you", "room", 1), PATIENCE_S)
    assert making.fraction < 1.0


def test_a_page_reads_how_far_its_story_is_and_leaving_it_ends_it(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    went_on, ended = threading.Event(), threading.Event()

    def slow(_: Any, *, may_continue: Callable[[], bool], report: Callable[[float], None], **__: Any) -> LiveMap:
        report(0.25)
        went_on.set()
        while may_continue():
            threading.Event().wait(0.005)
        ended.set()
        raise WorkCancelledError("story.unwanted", "It is not wanted.")

    with running(settings_for(tmp_path)) as service:
        monkeypatch.setattr("server.sources.simulation_replay.replayed", slow)
        _check_leaving(service, went_on, ended)


def _check_leaving(service: Service, went_on: threading.Event, ended: threading.Event) -> None:
    service.http.get("/")  # the visitor's cookie
    wanted = {"kind": "simulation", "name": "mine", "story": {"steps": 5}}
    base = service.http.base_url
    cookies = "; ".join(f"{name}={value}" for name, value in service.http.cookies.items())
    headers = {"Content-Type": "application/json", "Cookie": cookies}
    with contextlib.closing(HTTPConnection(base.host, base.port or 80)) as page:
        page.request("POST", "/api/sessions", json.dumps(wanted), headers)
        assert went_on.wait(PATIENCE_S)
        told = service.http.get("/api/sessions/making/mine").json()
        assert told["fraction"] == 0.25
        assert told["elapsed_s"] >= 0.0
        assert httpx.get(f"{base}/api/sessions/making/mine").status_code == 204  # it is nobody else's
    assert ended.wait(PATIENCE_S)
    until(lambda: service.http.get("/api/sessions/making/mine").status_code == 204)
