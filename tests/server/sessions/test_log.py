"""A log session: its clock, and its map against the mapper's."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mapper.core.errors import LimitError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.diagnosis import Diagnosis
from mapper.grid import OccupancyGrid
from mapper.io.logs import open_log
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog, Trajectory
from server.parts.why.part import CellAsked, why_message
from server.parts.wire import command_of
from server.sessions import LogView, SessionRegistry
from server.sessions.computation import hello_message
from server.sessions.tick import TickResult
from server.sources.log import MAX_GAP_S, play_times
from server.sources.log_recording import first_replay
from server.stream.messages import ErrorMessage
from server.stream.protocol import ProtocolError
from tests.server.begin import new_log
from tests.server.sent import sent
from tests.server.service import PATIENCE_S, eventually
from tests.server.view import view_of

WELL = Diagnosis((), ())


def whole_map(log: ScanLog, config: MappingConfig, stop: int | None = None) -> OccupancyGrid:
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config, stop=stop)
    return grid


@given(arrays(np.int64, st.integers(1, 50), elements=st.integers(-(2**63), 2**63 - 1)))
def test_play_times_never_decrease_and_never_leap(stamps: Any) -> None:
    times = play_times(stamps)
    assert times.shape == stamps.shape
    assert times[0] == 0.0
    gaps = np.diff(times)
    assert (gaps >= 0.0).all()
    assert (gaps <= MAX_GAP_S + 1e-9).all()
    assert len(stamps) == 1 or times[-1] > 0.0


def test_play_times_are_the_recorded_ones_where_those_are_sound() -> None:
    stamps = np.array([0, 100, 250, 240, 5000, 5100]) * 1_000_000 + 10**18
    assert play_times(stamps) == pytest.approx([0.0, 0.1, 0.25, 0.25, 2.25, 2.35])


async def test_at_the_end_of_the_log_the_map_is_complete(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    assert session.model.progress == (0, office_log.n_scans)
    await obey(session, type="seek", index=office_log.n_scans)
    expected = whole_map(office_log, session.model.config)
    assert view_of(session).geometry == expected.geometry
    np.testing.assert_array_equal(view_of(session).log_odds, expected.log_odds)
    np.testing.assert_array_equal(view_of(session).observed, expected.observed)
    for index in (10, 77, 3, 0, 50):
        await obey(session, type="seek", index=index)
        np.testing.assert_array_equal(
            view_of(session).log_odds, whole_map(office_log, session.model.config, stop=index).log_odds
        )
        assert session.model.progress[0] == index


async def test_several_sensors_make_one_map_and_why_says_which(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    late = replace(
        office_log.take(slice(0, 40)),
        ranges=office_log.ranges[:40, ::2].copy(),
        angle_increment=2 * office_log.angle_increment,
        mount=(-0.3, 0.0, 3.0),
        topic="/rear",
    )
    joint = JointLog.of([replace(office_log.take(slice(0, 40)), topic="/front"), late])
    session = await new_log(registry, "me", joint)
    await obey(session, type="seek", index=joint.n_scans)
    expected = whole_map(joint, session.model.config)
    np.testing.assert_array_equal(view_of(session).log_odds, expected.log_odds)
    state = session.model.recording.robot_state()
    assert len(state.scan.ranges) == late.n_beams  # of equal stamps the first sensor's scan is first
    assert state.sensor_pose == pytest.approx(tuple(late.sensor_poses()[-1]))
    row, col = (int(n) for n in np.argwhere(expected.log_odds > 2.0)[0])
    source = session.model.recording.sources()
    told = why_message(expected, source, session.model.config, CellAsked(row, col, 0, 0, "belief"))
    assert {one.sensor for one in told.contributions} <= {"/front", "/rear"}
    for one in told.contributions:
        part = joint.parts[int(joint.part_of_scan[one.scan])]
        assert one.sensor == part.topic
        assert one.bearing == pytest.approx(part.angles[one.beam], abs=1e-4)
        assert one.pose == pytest.approx(joint.sensor_poses()[one.scan], abs=1e-3)


async def test_parameters_remake_the_map_at_the_same_scan(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=40)
    await obey(session, type="parameters", values={"update": "per_scan", "resolution": 0.1})
    np.testing.assert_array_equal(
        view_of(session).log_odds, whole_map(office_log, session.model.config, stop=40).log_odds
    )
    assert session.model.progress[0] == 40


async def test_a_seek_to_where_the_map_is_changes_nothing(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=40)
    for index, is_change in ((40, False), (41, True)):
        result = TickResult()
        session.model.handle(command_of({"type": "seek", "index": index}), result)
        assert result.changed is is_change


async def test_it_plays_to_its_end_and_from_the_start_again(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    assert session.model.playback.playing
    client = session.join()
    await obey(session, type="speed", value=session.model.playback.speeds[1])
    heard: list[str] = []

    def ended() -> bool:
        heard.extend(str(message) for message in client.take())
        return '"code":"log.end"' in "".join(heard)

    await eventually(ended)
    assert not bool(session.model.playback.playing)
    assert session.model.progress[0] == office_log.n_scans
    await obey(session, type="speed", value=0.1)
    await obey(session, type="play")
    assert session.model.playback.playing
    assert session.model.progress[0] < 5


async def test_it_fills_in_about_half_a_minute(registry: SessionRegistry, office_log: ScanLog) -> None:
    session = await new_log(registry, "me", office_log)
    duration = float(office_log.stamps_ns[-1] - office_log.stamps_ns[0]) * 1e-9
    assert duration / session.model.playback.speed == pytest.approx(30.0, rel=0.1)


async def test_steps_stay_within_the_log(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="step", scans=5)
    assert session.model.progress[0] == 5
    assert not session.model.playback.playing
    await obey(session, type="step", scans=-2)
    assert session.model.progress[0] == 3
    await obey(session, type="step", scans=-100)
    assert session.model.progress[0] == 0
    await obey(session, type="step", scans=10**6)
    assert session.model.progress[0] == office_log.n_scans
    await obey(session, type="restart")
    assert session.model.progress[0] < 5
    assert session.model.playback.playing


async def test_another_trajectory_makes_another_map(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log, view=LogView(trajectory="true"))
    await obey(session, type="pause")
    await obey(session, type="seek", index=100)
    await obey(session, type="trajectory", name="odometry")
    config = session.model.config
    grid = OccupancyGrid(geometry_for(office_log, config, "odometry"))
    integrate_log(grid, office_log, config, "odometry", stop=100)
    assert session.model.recording.trajectory == "odometry"
    assert view_of(session).geometry == grid.geometry
    np.testing.assert_array_equal(view_of(session).log_odds, grid.log_odds)
    odometry = office_log.trajectory("odometry").poses
    assert view_of(session).pose == pytest.approx(tuple(odometry[99]))


async def test_the_3d_view_frames_all_cells_that_the_whole_log_sees(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=office_log.n_scans)
    view = view_of(session)
    cells = np.argwhere(view.observed)
    low, high = (view.geometry.cell_to_world(corner) for corner in (cells.min(axis=0), cells.max(axis=0)))
    assert session.model.controls().bounds == pytest.approx((*low, *high), abs=2 * view.geometry.resolution)
    await obey(session, type="seek", index=1)
    assert session.model.controls().bounds == pytest.approx((*low, *high), abs=2 * view.geometry.resolution)


@pytest.mark.parametrize(
    "command",
    [
        {"type": "seek", "index": -1},
        {"type": "seek", "index": 151},
        {"type": "seek", "index": 1.5},
        {"type": "step", "scans": "two"},
        {"type": "trajectory", "name": "dreams"},
        {"type": "teleport", "x": 1, "y": 1},
        {"type": "speed", "value": 0},
        {"type": "parameters", "values": {"resolution": 0}},
    ],
)
async def test_a_refused_command_changes_nothing(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, command: dict[str, Any]
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=20)
    before = view_of(session)
    client = session.join()
    client.take()
    try:
        session.enqueue(command_of(command), client)
    except ProtocolError as error:  # as the socket refuses it
        client.send(ErrorMessage(error.code, error.message))
    await obey(session, type="pause")
    assert '"type":"error"' in "".join(str(message) for message in client.take())
    after = view_of(session)
    assert (after.index, after.playing, session.model.config) == (20, False, before.config)
    np.testing.assert_array_equal(after.log_odds, before.log_odds)


async def test_a_log_is_examined_once_for_each_trajectory(registry: SessionRegistry, office_log: ScanLog) -> None:
    session = await new_log(registry, "me", replace(office_log, mount=(0.0, 0.0, np.pi)))
    first, again = await asyncio.gather(session.model.recording.examined(), session.model.recording.examined())
    assert [finding.check for finding in first.findings] == ["mount.turned"]
    assert again is first


@pytest.mark.skipif(sys.platform != "linux", reason="only there has a thread a niceness of its own")
async def test_an_examination_is_deferred_to_interactive_work(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = os.getpriority(os.PRIO_PROCESS, 0)
    found: list[int] = []

    def look(*_: Any, **__: Any) -> Diagnosis:
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))
        return WELL

    monkeypatch.setattr("mapper.diagnosis.diagnose", look)
    session = await new_log(registry, "me", office_log)
    assert await session.model.recording.examined() == WELL
    assert found == [min(own + 10, 19)]
    assert os.getpriority(os.PRIO_PROCESS, 0) == own


async def test_an_examination_ends_with_its_session(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log)
    begun, maps = threading.Event(), 0

    def slow(*arguments: Any) -> None:
        nonlocal maps
        maps += 1
        begun.set()
        while not session.closed:
            time.sleep(0.001)
        integrate_scans(*arguments)

    monkeypatch.setattr("mapper.diagnosis.consistency.integrate_scans", slow)
    asked = asyncio.ensure_future(session.model.recording.examined())
    assert await asyncio.to_thread(begun.wait, PATIENCE_S)
    await registry.close(session.id)
    with pytest.raises(WorkCancelledError):
        await asked
    assert maps == 1


async def test_an_examination_ends_when_nobody_waits_for_it_any_more(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log)
    recording = session.model.recording
    begun, ended, maps = threading.Event(), threading.Event(), 0

    def examined(*_: Any, may_continue: Callable[[], bool]) -> list[Any]:
        nonlocal maps
        maps += 1
        begun.set()
        while may_continue():
            time.sleep(0.001)
        ended.set()
        raise WorkCancelledError("doctor.unwanted", "The examination is not wanted any more.")

    with monkeypatch.context() as patched:
        patched.setattr("mapper.diagnosis.diagnose", examined)
        one, other = (asyncio.ensure_future(recording.examined()) for _ in range(2))
        assert await asyncio.to_thread(begun.wait, PATIENCE_S)
        one.cancel()
        await asyncio.wait([one])
        assert not ended.is_set(), "the other one still waits"
        other.cancel()
        assert await asyncio.to_thread(ended.wait, PATIENCE_S)
    assert maps == 1
    assert recording.examined_share is None
    assert await recording.examined() == WELL


async def test_a_newer_command_does_not_end_an_examination(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log)
    # As while a map is computed that a newer slider move replaces.
    monkeypatch.setattr(session._requests, "_is_outdated", lambda: True)
    with session.cancellable():
        assert not session.may_continue()
        assert await session.model.recording.examined() == WELL


async def test_a_failed_examination_is_repeated(
    registry: SessionRegistry, office_log: ScanLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_log(registry, "me", office_log)

    def no_memory(*_: Any) -> None:
        raise MemoryError

    with monkeypatch.context() as patched:
        patched.setattr("mapper.diagnosis.consistency.integrate_scans", no_memory)
        for asked in await asyncio.gather(
            session.model.recording.examined(), session.model.recording.examined(), return_exceptions=True
        ):
            assert isinstance(asked, MemoryError)
    assert await session.model.recording.examined() == WELL


async def test_a_laser_that_hangs_upside_down_is_shown_seen_from_above(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", replace(office_log, upside_down=True))
    await obey(session, type="seek", index=1)
    view = view_of(session)
    np.testing.assert_array_equal(view.angles, -office_log.angles)


async def test_a_log_that_is_too_large_at_first_is_mapped_coarser(
    make_registry: Callable[..., SessionRegistry], office_log: ScanLog
) -> None:
    registry = make_registry(max_cells=50_000)
    session = await new_log(registry, "me", office_log)
    assert session.model.config.resolution == 0.1
    assert session.cells <= 50_000
    with pytest.raises(LimitError):
        await new_log(make_registry(max_cells=4096), "me", office_log)


async def test_times_are_the_recorded_ones_though_pauses_are_played_short(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    """A clock that steps back and a pause of 100 s: the page hears of the recorded time, which never goes back."""
    stamps = np.arange(office_log.n_scans) * 1_000_000_000 + 10**18
    stamps[50] -= 20_000_000_000
    stamps[60:] += 100_000_000_000
    session = await new_log(registry, "me", replace(office_log, stamps_ns=stamps))
    duration = float(office_log.n_scans - 1 + 100)
    log = hello_message(session.model, "", "").log
    assert log is not None
    assert log.duration_s == pytest.approx(duration)
    heard = []
    for index in (1, 50, 51, 52, 60, 61, office_log.n_scans):
        await obey(session, type="seek", index=index)
        heard.append(session.model.recording.robot_state().stamp_s)
    assert heard == pytest.approx([0.0, 49.0, 49.0, 51.0, 59.0, 160.0, duration])


@pytest.mark.parametrize(("n_scans", "every"), [(20_000, 1), (20_001, 2), (50_000, 3)])
async def test_the_path_of_a_long_log_is_thinned_and_noted(
    registry: SessionRegistry, office_log: ScanLog, n_scans: int, every: int
) -> None:
    log = replace(
        office_log,
        ranges=np.full((n_scans, 1), 1.0, dtype=np.float32),
        stamps_ns=np.arange(n_scans) * 100_000_000,
        trajectories={"scan": Trajectory(np.stack([np.arange(n_scans) * 1e-3] * 2 + [np.zeros(n_scans)], axis=-1))},
    )
    session = await new_log(registry, "me", log)
    way = next(message for message in sent(session.model.messages()) if message["type"] == "trajectory")
    assert (way["name"], way["every"]) == ("scan", every)
    assert len(way["poses"]) == len(way["stamps"]) <= 20_000
    for i in (0, 1, 777, len(way["poses"]) - 1):
        assert way["poses"][i] == pytest.approx([i * every * 1e-3] * 2)
        assert way["stamps"][i] == pytest.approx(i * every * 0.1)
    assert n_scans - every <= (len(way["poses"]) - 1) * every < n_scans


def test_a_view_that_names_no_value_keeps_the_tables_and_a_new_one_gets_the_recordings(office_log: ScanLog) -> None:
    older = asdict(MappingConfig(window=0.3))
    del older["hit_and_passed"]
    shown = first_replay(office_log, LogView(values=older), DEFAULT_LIMITS).config
    assert (shown.window, shown.hit_and_passed) == (0.3, "both_count")
    assert first_replay(office_log, LogView(), DEFAULT_LIMITS).config.hit_and_passed == "only_hits"


async def test_the_intel_log(
    registry: SessionRegistry, obey: Callable[..., Any], data_file: Callable[[str], Path]
) -> None:
    log = open_log(data_file("carmen/intel-corrected.log.gz"))
    session = await new_log(registry, "me", log)
    await obey(session, type="seek", index=log.n_scans)
    expected = whole_map(log, MappingConfig(range_max=30.0, resolution=0.05, hit_and_passed="only_hits"))
    assert view_of(session).geometry == expected.geometry
    np.testing.assert_array_equal(view_of(session).log_odds, expected.log_odds)
