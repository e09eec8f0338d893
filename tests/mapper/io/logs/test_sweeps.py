"""Sweeps that the readings of a log contradict, and sweeps that they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose
from mapper.io.logs.understanding import understood
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from tests.mapper.mapping.sweeping import BEAMS, RATE, STEP, swept, to_the_walls, true_poses

N = 160
SWEEP = STEP * BEAMS


def with_poses(log: ScanLog, *, drift: float = 0.0, noise: float = 0.0) -> ScanLog:
    """The log with poses 50 times a second that turn by ``drift`` radians a second, with ``noise`` (m, rad)."""
    times = np.arange(99.0, 100.0 + N / RATE + 1.0, 0.02)
    turned = np.stack([0.0 * times, 0.0 * times, drift * times], axis=-1)
    poses = compose(turned, true_poses(times)) + np.random.default_rng(3).normal(0.0, noise, (len(times), 3))
    timed = TimedPoses(np.round(times * 1e9).astype(np.int64), poses)
    return replace(log, trajectories={"odom": Trajectory(timed.at(log.stamps_ns), timed=timed)})


def at_once(increment: float) -> ScanLog:
    """A log of scans whose beams were all measured at the stamp, and that state an increment."""
    log = swept(N)
    poses = np.repeat(true_poses(log.stamps_ns * 1e-9)[:, np.newaxis], BEAMS, axis=1)
    poses[..., 2] += log.angles
    return replace(log, ranges=to_the_walls(poses).astype(np.float32), time_increment=increment)


def read(log: ScanLog) -> ScanLog:
    return understood(RobotLog.of_one(log)).first


@pytest.mark.parametrize("delay", [0.0, 0.5 * SWEEP, SWEEP, -0.5 * SWEEP, 0.03, 0.15, 0.3, -0.2, -1.0])
@pytest.mark.parametrize("wrong", [{}, {"drift": 0.02}, {"noise": 0.01}])
def test_a_true_sweep_is_used_whatever_the_clocks_and_the_poses_are(delay: float, wrong: dict[str, float]) -> None:
    """Of a scan that is stamped late beams at the stamp fit better than at the stated times, and neither does well."""
    log = read(with_poses(swept(N, delay=delay), **wrong))
    assert (log.time_increment, log.notes) == (STEP, ())


@pytest.mark.parametrize("share", [0.05, 0.5, 2.0])
def test_a_true_sweep_of_another_length_is_used(share: float) -> None:
    assert read(with_poses(replace(swept(N), time_increment=min(share, 1.2) * STEP))).time_increment > 0.0


@pytest.mark.parametrize("increment", [STEP, -STEP, 0.5 * STEP])
@pytest.mark.parametrize("wrong", [{}, {"drift": 0.01}, {"noise": 0.01}])
def test_a_sweep_of_scans_that_were_taken_at_once_is_not_used(increment: float, wrong: dict[str, float]) -> None:
    log = read(with_poses(at_once(increment), **wrong))
    assert log.time_increment == 0.0
    (note,) = log.notes
    assert note.startswith(
        f"A sweep of 360 beams takes {abs(increment) * (BEAMS - 1):.3g} s by the stated time_increment"
    )
