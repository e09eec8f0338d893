"""Poses that are stamped late or by a clock of another rate, and poses that only drift."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.diagnosis import examine
from mapper.diagnosis.timing import CLOCK
from mapper.io.logs.understanding import understood
from mapper.io.trajectories import with_trajectory
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from tests.mapper.mapping.sweeping import to_the_walls

N, PERIOD = 120, 0.2
BEARINGS = np.linspace(-math.pi, math.pi, 360, endpoint=False)


def way(times: np.ndarray) -> np.ndarray:
    """The true poses: along a line through the room, as the robot looks to the left and to the right."""
    along = -2.0 + 4.0 * times / (N * PERIOD)
    return np.stack([along, 0.5 * np.sin(along), 0.6 * np.sin(2.0 * math.pi * times / 3.0)], axis=-1)


def seen(noise: float = 0.0) -> ScanLog:
    """Scans that are measured at once, without poses."""
    times = PERIOD * np.arange(N)
    poses = np.repeat(way(times)[:, np.newaxis], len(BEARINGS), axis=1)
    poses[..., 2] += BEARINGS
    ranges = to_the_walls(poses) + np.random.default_rng(1).normal(0.0, noise, poses.shape[:2])
    stamps = np.round(times * 1e9).astype(np.int64)
    step = float(BEARINGS[1] - BEARINGS[0])
    return ScanLog(ranges.astype(np.float32), -math.pi, step, 0.1, 20.0, stamps, {"odom": Trajectory(way(times))})


def read(log: ScanLog, stamps: np.ndarray, poses: np.ndarray) -> ScanLog:
    timed = TimedPoses(np.round(stamps * 1e9).astype(np.int64), poses)
    given = replace(log, trajectories={"odom": Trajectory(timed.at(log.stamps_ns), timed=timed)})
    return understood(RobotLog.of_one(given)).first


TIMES = np.arange(-1.0, N * PERIOD + 1.0, 0.02)


def errors(log: ScanLog) -> tuple[float, float]:
    """By how much the poses at the scans are off at most, metres and radians."""
    away = log.trajectory().poses - way(log.stamps_ns * 1e-9)
    return float(np.abs(away[:, :2]).max()), float(np.abs(wrap_angle(away[:, 2])).max())


@pytest.mark.parametrize("delay", [0.03, -0.1])
def test_poses_that_are_stamped_late_are_taken_from_when_they_were(delay: float) -> None:
    log = read(seen(0.01), TIMES + delay, way(TIMES))
    assert np.all(np.less(errors(log), (0.005, 0.012)))
    assert f"stamped 0.{'03' if delay > 0 else '1'}" in log.wrong_clock
    assert f"too {'late' if delay > 0 else 'early'}, or the scans" in log.wrong_clock
    assert log.notes == (log.wrong_clock,)
    timed = log.trajectory().timed
    assert timed is not None
    np.testing.assert_allclose(timed.stamps_ns * 1e-9, TIMES, atol=0.008)


@pytest.mark.parametrize("rate", [0.004, -0.01])
def test_a_clock_that_runs_at_another_rate_is_followed(rate: float) -> None:
    log = read(seen(), TIMES * (1.0 + rate), way(TIMES))
    assert np.all(np.less(errors(log), (0.005, 0.03)))
    assert f"parts per million {'faster' if rate > 0 else 'slower'}" in log.wrong_clock
    timed = log.trajectory().timed
    assert timed is not None
    np.testing.assert_allclose(timed.stamps_ns * 1e-9, TIMES, atol=0.02)


def test_the_doctor_names_the_clock_and_no_delay_in_its_place() -> None:
    found = examine(read(seen(), TIMES + 0.05, way(TIMES)))
    assert [(one.check, one.parameters) for one in found] == [(CLOCK, None)]


def reckoned(scale: float = 1.0, turn: float = 1.0, bias: float = 0.0) -> np.ndarray:
    """Poses by wheels that measure ``scale`` times the way, ``turn`` times the turns and ``bias`` rad/s more."""
    true = way(TIMES)
    steps = compose(inverse(true[:-1]), true[1:])
    steps = np.stack([steps[:, 0] * scale, steps[:, 1] * scale, wrap_angle(steps[:, 2]) * turn + 0.02 * bias], axis=-1)
    poses = [true[0]]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


@pytest.mark.parametrize(
    "poses",
    [
        way(TIMES),
        reckoned(scale=1.05),
        reckoned(turn=1.1),
        reckoned(bias=0.02),
        way(TIMES) + np.random.default_rng(2).normal(0.0, (0.02, 0.02, 0.01), (len(TIMES), 3)),
    ],
    ids=["true", "scale", "turn", "bias", "noise"],
)
def test_poses_that_are_wrong_otherwise_are_not_called_late(poses: np.ndarray) -> None:
    assert read(seen(0.01), TIMES, poses).wrong_clock == ""


@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_poses_of_a_tum_file_that_are_stamped_late_are_taken_from_when_they_were(delay: float) -> None:
    poses = TimedPoses(np.round((TIMES + delay) * 1e9).astype(np.int64), way(TIMES))
    log = with_trajectory(seen(0.01), poses)
    assert np.all(np.less(errors(log), (0.005, 0.012)))
    assert [note for note in log.notes if "stamped 0.1 s too late" in note] == [*log.notes]
    assert bool(log.notes) == (delay > 0.0)
