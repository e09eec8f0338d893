"""Transform trees that no robot has: cycles, chains of thousands, thousands of sensors on one chain."""

from __future__ import annotations

import pytest

from mapper.core.array_types import Int64Array
from mapper.core.errors import LimitError
from mapper.io.logs.recording.poses3 import Poses3
from mapper.io.logs.recording.timeline import Timeline
from mapper.io.logs.recording.transforms import MAX_DEPTH, MAX_WORLDS
from mapper.sensors.scan import ScanLog
from tests.hostile.corpus import T0
from tests.hostile.damage import opened
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, scan, transform


def chain(n: int, *, moving: bool = False) -> list[recorded.Said]:
    """n frames above f0, each 0.1 m ahead of the one below."""
    times = (T0, T0 + SECOND) if moving else (T0,)
    return [transform(at, f"f{i + 1}", f"f{i}", 0.1 + (at - T0) / SECOND) for i in range(n) for at in times]


def test_frames_that_go_round_in_a_circle(tmp_path):
    circle = [transform(T0 + i, f"f{(i + 1) % 5}", f"f{i}", 0.1 * i) for i in range(5)]
    said = [*circle, scan(T0, [1.0], frame="f0"), transform(T0, "f0", "f0")]
    log = opened(tmp_path / "a.log", recorded.mcap_bytes(said))
    assert isinstance(log, ScanLog)
    assert "The transforms form a loop, f0 in f1 in f2 in f3 in f4 in f0: they are followed up to 'f4'." in log.notes


def test_a_chain_of_thousands_is_refused(tmp_path):
    error = opened(tmp_path / "a.log", recorded.mcap_bytes([*chain(3000), scan(T0, [1.0], frame="f0")]))
    assert isinstance(error, LimitError)
    assert error.code == "log.too_many_frames"
    assert isinstance(
        opened(tmp_path / "a.log", recorded.mcap_bytes([*chain(MAX_DEPTH - 1), scan(T0, [1.0], frame="f0")])), ScanLog
    )


def test_a_robot_in_many_world_frames_gives_few_trajectories(tmp_path):
    said = [*chain(MAX_DEPTH - 1, moving=True), scan(T0, [1.0], frame="f0"), scan(T0 + SECOND, [1.0], frame="f0")]
    log = opened(tmp_path / "a.log", recorded.mcap_bytes(said))
    assert isinstance(log, ScanLog)
    assert len(log.trajectories) == MAX_WORLDS


def test_frames_are_sorted_once_for_any_number_of_sensors(tmp_path, monkeypatch: pytest.MonkeyPatch):
    orders: list[Timeline] = []
    put_in_order = Timeline._put_in_order

    def counted(line: Timeline) -> tuple[Int64Array, Poses3, Int64Array]:
        orders.append(line)
        return put_in_order(line)

    monkeypatch.setattr(Timeline, "_put_in_order", counted)
    said = chain(20, moving=True)[::-1] + [scan(T0 + i, [1.0], f"/scan{i}", "f0") for i in range(300)]
    log = opened(tmp_path / "a.log", recorded.mcap_bytes(said))
    assert isinstance(log, ScanLog)
    assert len([topic for topic in log.topics if topic.beams]) == 300
    assert len(orders) <= 20 + 5
