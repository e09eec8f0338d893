"""The simulation session: what its map is made of, and the effects of commands."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import integrate_log
from mapper.replay import Replay
from mapper.simulation import WORLDS, Faults, SensorConfig
from mapper.simulation.live_map import LiveMap
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.stream.commands import ParametersCommand, SeekCommand
from server.stream.messages import ErrorMessage
from server.stream.protocol import ProtocolError
from tests.server.begin import between_ticks, new_simulation
from tests.server.service import PATIENCE_S, eventually
from tests.server.view import view_of


@pytest.mark.parametrize("values", [{}, {"resolution": 0.1}, {"update": "per_scan", "window": 0.4}, {"range_max": 3.0}])
def test_a_recomputed_map_equals_the_replay_of_the_recording(values: dict[str, Any]) -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    mapper.advance(6.0)
    mapper.remake(mapper.config.with_values(values))
    (log,) = mapper.logs()
    replay = Replay(log, mapper.config)
    rows, cols = replay.grid.geometry.shape
    corners = replay.grid.geometry.cell_to_world([(0, 0), (rows - 1, cols - 1)])
    assert mapper.grid.geometry.contains(mapper.grid.geometry.world_to_cell(corners)).all()
    # On the same lattice: an endpoint on a cell's border may be rounded to either side of it from another origin.
    grid = OccupancyGrid(mapper.grid.geometry)
    integrate_log(grid, log, mapper.config)
    np.testing.assert_array_equal(mapper.grid.log_odds, grid.log_odds)
    np.testing.assert_array_equal(mapper.grid.observed, grid.observed)


def test_the_map_that_grew_scan_by_scan_is_the_remade_one() -> None:
    mapper = LiveMap(WORLDS["loop"], seed=2)
    mapper.advance(8.0)
    grown = np.where(mapper.grid.observed, mapper.grid.log_odds, np.nan)
    geometry = mapper.grid.geometry
    mapper.remake(mapper.config)
    assert mapper.grid.geometry == geometry
    np.testing.assert_array_equal(np.where(mapper.grid.observed, mapper.grid.log_odds, np.nan), grown)


def test_a_new_sensor_adds_to_the_same_map() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    mapper.advance(2.0)
    before = mapper.grid.observed.copy()
    mapper.set_sensor(SensorConfig(n_beams=90, range_max=4.0))
    mapper.advance(2.0)
    assert [log.n_beams for log in mapper.logs()] == [360, 90]
    assert mapper.grid.observed[before].all()
    mapper.remake(mapper.config)
    assert mapper.grid.observed[before].all()


def test_many_sensors_do_not_pile_up() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    for n_beams in list(range(30, 600, 30)) * 3:
        mapper.set_sensor(SensorConfig(n_beams=n_beams))
        mapper.look()
    assert len(mapper.recordings) <= 32
    assert mapper.logs()[0].n_beams == 360  # the longest one is kept


def test_a_change_of_the_sensor_that_is_cancelled_has_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mapper.simulation.live_map.MAX_SEGMENTS", 2)
    mapper = LiveMap(WORLDS["room"], seed=1)
    mapper.advance(1.0)
    mapper.set_sensor(SensorConfig(n_beams=60))
    mapper.advance(0.5)
    sensor, grid, recordings = mapper.simulation.sensor, mapper.grid, [*mapper.recordings]
    mapper.may_continue = lambda: False
    with pytest.raises(WorkCancelledError):
        mapper.set_sensor(SensorConfig(n_beams=90))  # one recording too many: the map is made again
    assert (mapper.simulation.sensor, mapper.grid is grid, mapper.recordings) == (sensor, True, recordings)
    mapper.may_continue = lambda: True
    mapper.advance(1.0)
    assert [log.n_beams for log in mapper.logs()] == [360, 60]


def test_a_map_that_would_be_too_large_is_refused_and_the_old_one_stays() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1, limits=lambda: Limits(max_cells=1 << 20))
    before = mapper.grid
    with pytest.raises(LimitError, match="coarser"):
        mapper.remake(mapper.config.with_values({"resolution": 0.01}))
    assert mapper.grid is before
    assert mapper.config.resolution == 0.05


async def test_a_visitor_arrives_at_a_map_that_is_alive(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    view = view_of(session)
    assert view.observed.sum() > 5000
    assert view.playing
    assert view.index == view.count > 10
    assert view.world is WORLDS["room"]
    assert view.range_max == 10.0
    assert (view.config.range_max, view.config.window, view.config.resolution) == (10.0, 0.2, 0.05)


async def test_the_same_seed_gives_the_same_map(registry: SessionRegistry) -> None:
    one = await new_simulation(registry, "me", "room", seed=4)
    same = await new_simulation(registry, "me", "room", seed=4)
    other = await new_simulation(registry, "me", "room", seed=5)
    assert view_of(one).log_odds.tobytes() == view_of(same).log_odds.tobytes()
    assert view_of(one).log_odds.tobytes() != view_of(other).log_odds.tobytes()


async def test_a_simulation_runs_only_while_a_client_is_connected(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    count = view_of(session).count
    await asyncio.sleep(0.3)
    assert view_of(session).count == count
    ticks = asyncio.Event()
    session.listen(ticks.set)
    await asyncio.wait_for(ticks.wait(), PATIENCE_S)
    await eventually(lambda: view_of(session).count != count)
    session.ignore(ticks.set)
    await between_ticks(session)
    await asyncio.sleep(0.1)
    stopped = view_of(session).pose
    await asyncio.sleep(0.2)
    assert view_of(session).pose == stopped


async def test_a_late_client_gets_the_present_state_only(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    for _ in range(2):
        await asyncio.sleep(0.3)
        came = time.monotonic()
        client = session.join()
        frames = [json.loads(m) for m in client.take() if isinstance(m, str) and '"type":"frame"' in m]
        assert [frame["t"] >= came - 1e-4 for frame in frames] == [True]
        count = view_of(session).count
        await eventually(lambda count=count: view_of(session).count > count)  # type: ignore[misc]
        session.leave(client)


async def test_a_teleport_sees_at_once_even_when_paused(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "office", seed=4)
    await obey(session, type="pause")
    before = view_of(session).observed.copy()
    count = view_of(session).count
    room = WORLDS["office"].nearest_free((17.0, 12.0), 0.3)
    await obey(session, type="teleport", x=float(room[0]), y=float(room[1]))
    view = view_of(session)
    assert not view.playing
    assert view.count == count + 1
    assert view.pose[:2] == pytest.approx(tuple(room))
    near = np.hypot(*(np.moveaxis(cell_centres(view.geometry), -1, 0) - room[:, None, None])) < 1.0
    assert (view.observed & ~before)[near].sum() > 100


def cell_centres(geometry: Any) -> NDArray[np.float64]:
    rows, cols = geometry.shape
    cells = np.stack(np.meshgrid(np.arange(rows), np.arange(cols), indexing="ij"), axis=-1)
    return np.asarray(geometry.cell_to_world(cells), dtype=np.float64)


async def test_step_adds_the_given_number_of_scans(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    count = view_of(session).count
    await obey(session, type="step", scans=7)
    assert view_of(session).count == count + 7
    assert not view_of(session).playing


@pytest.mark.parametrize("values", [{}, {"drift": True, "specular": True}])
def test_steps_back_and_on_are_the_map_of_so_many_scans(values: dict[str, bool]) -> None:
    mapper = LiveMap(WORLDS["room"], seed=4)
    mapper.set_up(mapper.config, Faults(**values))
    mapper.compare({"clamp": False})
    second = mapper.second
    assert second is not None
    maps, poses = [], []
    for _ in range(6):
        mapper.step(1)
        maps.append((mapper.grid.log_odds.copy(), second.grid.log_odds.copy()))
        poses.append((mapper.newest_pose, mapper.believed_pose))
    for back in range(1, 6):
        assert mapper.step_back(1)
        for grid, expected in zip((mapper.grid, second.grid), maps[5 - back], strict=True):
            np.testing.assert_array_equal(grid.log_odds, expected)
        assert (mapper.newest_pose, mapper.believed_pose) == poses[5 - back]
    mapper.step(2)
    np.testing.assert_array_equal(mapper.grid.log_odds, maps[2][0])
    # Whoever lets time pass has all scans in the map again, and the next one after them.
    mapper.advance(0.2)
    assert mapper.hidden == 0
    assert mapper.scans == len(mapper.recordings[-1])
    grown = mapper.grid.log_odds.copy()
    mapper.remake(mapper.config)
    np.testing.assert_array_equal(mapper.grid.log_odds, grown)
    mapper.step_back(10**6)
    assert mapper.scans - mapper.hidden == 1  # the first stays


async def test_a_negative_step_restores_the_earlier_map(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    before = view_of(session)
    index, log_odds = before.index, before.log_odds.copy()
    await obey(session, type="step", scans=-3)
    view = view_of(session)
    assert (view.index, view.count) == (index - 3, index)
    assert view.pose == pytest.approx(view.sensor_pose)
    assert np.any(view.log_odds != log_odds)
    await obey(session, type="step", scans=3)
    np.testing.assert_array_equal(view_of(session).log_odds, log_odds)


async def test_restart_and_another_world_begin_a_new_map(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    count, first = view_of(session).count, view_of(session).log_odds.copy()
    await obey(session, type="step", scans=50)
    await obey(session, type="restart")
    again = view_of(session)
    assert again.count == count
    np.testing.assert_array_equal(again.log_odds, first)
    await obey(session, type="world", name="maze")
    assert view_of(session).world is WORLDS["maze"]
    assert session.model.title == WORLDS["maze"].title
    x0, y0, x1, y1 = WORLDS["maze"].bounds
    assert view_of(session).geometry.contains(view_of(session).geometry.world_to_cell([(x0, y0), (x1, y1)])).all()


@pytest.mark.usefixtures("one_tick")
async def test_of_many_parameters_only_the_newest_is_made(
    registry: SessionRegistry, obey: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    made: list[float] = []
    remake = LiveMap.remake

    def counted(mapper: LiveMap, config: Any) -> None:
        made.append(config.window)
        remake(mapper, config)

    monkeypatch.setattr(LiveMap, "remake", counted)
    for i in range(100):
        session.enqueue(command_of({"type": "parameters", "values": {"window": 0.01 * i}}))
    await obey(session, type="parameters", values={"log_odds_hit": 1.5})
    assert made == [0.99]
    assert view_of(session).config.window == 0.99
    assert view_of(session).config.log_odds_hit == 1.5


@pytest.mark.parametrize(
    "command",
    [
        {"type": "seek", "index": 3},
        {"type": "step", "scans": 0},
        {"type": "step", "scans": 10**9},
        {"type": "speed", "value": 100},
        {"type": "world", "name": "nowhere"},
        {"type": "auto", "value": 1},
        {"type": "teleport", "x": "here", "y": 0},
        {"type": "teleport", "x": 1},
        {"type": "drive", "linear": True, "angular": 0},
        {"type": "sensor", "values": {"n_beams": 45.5}},
        {"type": "sensor", "values": {"colour": 1}},
        {"type": "parameters", "values": {"window": -1}},
        {"type": "parameters", "values": []},
        {"type": "inspect", "row": 10**6, "col": 0, "epoch": 1},
        {"type": "inspect", "row": 0, "col": 0, "epoch": 2},
        {"type": "fly"},
        {"type": "faults", "values": {"drift": "a little"}},
        {"type": "faults"},
        {"type": "compare", "values": {"colour": 1}},
        {"type": "compare", "values": 3},
        {"type": "edit", "added": [["box", 0, 0, 10**6, 10**6]]},
        {"type": "edit", "erased": [0]},
        {"type": "edit", "added": [], "watch": 1},
        {"type": "edit", "added": [], "watch": True},
        {"type": "world", "name": "room", "erased": [99999]},
    ],
)
async def test_a_refused_command_changes_nothing(
    registry: SessionRegistry, obey: Callable[..., Any], command: dict[str, Any]
) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    before, config, sensor = view_of(session), session.model.config, session.model.sensor
    client = session.join()
    client.take()
    try:
        session.enqueue(command_of(command), client)
    except ProtocolError as error:  # as the socket refuses it
        client.send(ErrorMessage(error.code, error.message))
    await obey(session, type="pause")
    answers = "".join(str(message) for message in client.take())
    assert '"type":"error"' in answers
    after = view_of(session)
    assert (after.count, after.pose, after.playing) == (before.count, before.pose, before.playing)
    assert (session.model.config, session.model.sensor, session.model.playback.speed) == (config, sensor, 1.0)
    np.testing.assert_array_equal(after.log_odds, before.log_odds)


async def test_there_is_no_such_world(registry: SessionRegistry) -> None:
    with pytest.raises(ConfigError, match="no world 'mars'"):
        await new_simulation(registry, "me", "mars")
    assert len(registry) == 0


async def test_a_defect_pauses_the_session_and_is_reported(
    registry: SessionRegistry, obey: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    client = session.join()

    def broken(*_: Any) -> None:
        raise ZeroDivisionError

    with monkeypatch.context() as patched:
        patched.setattr(LiveMap, "advance", broken)
        await eventually(lambda: not session.model.playback.playing)
        await obey(session, type="pause")
    assert '"playing":false' in session.hub.frame_text()
    assert '"code":"internal"' in "".join(str(message) for message in client.take())
    await obey(session, type="play")
    count = view_of(session).count
    await eventually(lambda: view_of(session).count != count)


async def test_commands_may_be_queued_from_any_thread(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await asyncio.to_thread(session.post, ParametersCommand({"window": 0.5}))
    await asyncio.to_thread(session.post, SeekCommand(3))
    await eventually(lambda: session.model.config.window == 0.5)


async def test_closing_calls_the_callbacks(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    closed: list[int] = []
    session.on_close += [lambda: closed.append(1), lambda: closed.remove(7), lambda: closed.append(2)]
    await registry.close(session.id)
    assert closed == [1, 2]
    await session.close()
    assert closed == [1, 2]


async def test_a_new_kind_of_sensor_begins_a_new_map_with_its_default_model(
    registry: SessionRegistry, obey: Callable[..., Any]
) -> None:
    session = await new_simulation(registry, "me", "room")
    await obey(session, type="sensor", values={"kind": "sonar_ring", "beam_width": 0.5})
    view = view_of(session)
    assert (view.config.model, view.config.opening) == ("sonar_cone", 0.5)
    assert len(view.ranges) == 16
    assert view.observed.any()
    await obey(session, type="sensor", values={"kind": "lidar"})
    assert view_of(session).config.model == "fixed_increments"


async def test_a_tick_asks_only_the_parts_that_are_on(
    registry: SessionRegistry, obey: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", "room", seed=1, playing=False)
    asked: list[str] = []
    optional = [part for part in session.model.parts if not part.is_on]
    for part in optional:
        monkeypatch.setattr(part, "changed", partial(lambda name, _: asked.append(name), type(part).__name__))
    await obey(session, type="parameters", values={"log_odds_hit": 1.5})
    assert asked == []
    await obey(session, type="costmap")
    assert asked == ["CostmapPart", "PathPart"]
    assert {type(part).__name__ for part in optional} > set(asked)
