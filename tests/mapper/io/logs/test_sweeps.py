"""Sweeps that the readings of a log contradict, and sweeps that they do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose
from mapper.diagnosis import examine, first_cause, sweep
from mapper.io.logs.understanding import understood
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from tests.mapper.mapping.sweeping import BEAMS, RATE, STEP, swept, to_the_walls, true_poses
from tests.marks import also_long

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


def reversed_order(delay: float = 0.0, n_scans: int = N) -> ScanLog:
    """A log of a lidar that turns clockwise, whose driver lists the beams counter-clockwise, in time too."""
    first = 100.0 + np.arange(n_scans) / RATE
    log = swept(n_scans, delay=delay)
    poses = true_poses(first[:, np.newaxis] + STEP * np.arange(BEAMS)[::-1])
    poses[..., 2] += log.angles
    return replace(log, ranges=to_the_walls(poses).astype(np.float32))


def read(log: ScanLog) -> ScanLog:
    return understood(RobotLog.of_one(log)).first


@pytest.mark.parametrize("delay", [0.5 * SWEEP, 0.3, -1.0, *also_long(0.0, SWEEP, -0.5 * SWEEP, 0.03, 0.15, -0.2)])
@pytest.mark.parametrize("wrong", [{}, {"drift": 0.02}, {"noise": 0.01}])
def test_a_true_sweep_is_used_whatever_the_clocks_and_the_poses_are(delay: float, wrong: dict[str, float]) -> None:
    """Of a scan that is stamped late beams at the stamp fit better than at the stated times, and neither does well."""
    log = read(with_poses(swept(N, delay=delay), **wrong))
    assert (log.time_increment, log.wrong_sweep) == (STEP, "")


@pytest.mark.parametrize("delay", [0.1, -0.2, *also_long(0.0, 0.15)])
@pytest.mark.parametrize("wrong", [{}, {"drift": 0.02}, {"noise": 0.01}])
def test_poses_that_are_late_hide_no_scans_that_were_taken_at_once(delay: float, wrong: dict[str, float]) -> None:
    log = at_once(STEP)
    stamps_ns = log.stamps_ns - round(delay * 1e9)
    assert read(with_poses(replace(log, stamps_ns=stamps_ns), **wrong)).time_increment == 0.0


@pytest.mark.parametrize("delay", [0.0, 0.1, -0.2])
@pytest.mark.parametrize("stated", [STEP, -STEP])
def test_beams_that_were_measured_in_the_other_order_are_taken_so(delay: float, stated: float) -> None:
    """Slamtec's drivers reverse the beams of lidars that turn clockwise, and state a positive increment."""
    made = reversed_order(delay) if stated > 0.0 else replace(swept(N, delay=delay), time_increment=stated)
    log = read(with_poses(made))
    assert log.time_increment == STEP
    assert f"the {'last' if stated > 0.0 else 'first'} beam first" in log.notes[0]
    # Each reading ends on a wall where the robot was when it was measured.
    poses = true_poses(log.stamps_ns[:, np.newaxis] * 1e-9 + delay + STEP * np.arange(BEAMS))
    poses[..., 2] += log.angles
    np.testing.assert_allclose(log.ranges, to_the_walls(poses), atol=1e-4)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (reversed_order(), "in the other order"),
        (at_once(STEP), "as measured at once"),
        (replace(swept(N), time_increment=4.0 * STEP), "state no possible time_increment"),
        (replace(at_once(0.0), time_increment=4.0 * STEP), "the scans are"),
        (swept(N), None),
    ],
    ids=["reversed", "at once", "too long", "too long, at once", "true"],
)
def test_the_doctor_names_a_sweep_that_was_found_wrong_when_the_log_was_read(made: ScanLog, said: str | None) -> None:
    """The map is right without it, but the sensor's driver is not; drift or a delay is not named in its place.

    The doctor looks at every third beam, as it takes their time.
    """
    whole = read(with_poses(made))
    log = replace(
        whole,
        ranges=whole.ranges[:, ::3].copy(),
        angle_increment=3.0 * whole.angle_increment,
        time_increment=3.0 * whole.time_increment,
    )
    found = examine(log)
    assert [one.check for one in found] == ([] if said is None else [sweep.CHECK])
    assert all(said in one.sentence and one.parameters is None for one in found if said is not None)
    assert first_cause(log, None, MappingConfig()) is None, "the map of the log is right"


@pytest.mark.parametrize("delay", [0.0, 0.05])
@pytest.mark.parametrize("made", [swept, reversed_order])
def test_a_sweep_that_is_not_stated_is_found(made: Callable[..., ScanLog], delay: float) -> None:
    """Of a lidar that turns clockwise, whose driver lists the beams the other way, the last beam is the first."""
    log = read(with_poses(replace(made(n_scans=N, delay=delay), time_increment=0.0)))
    assert log.time_increment == pytest.approx(STEP)
    assert "state no possible time_increment" in log.wrong_sweep
    poses = true_poses(log.stamps_ns[:, np.newaxis] * 1e-9 + delay + STEP * np.arange(BEAMS))
    poses[..., 2] += log.angles
    np.testing.assert_allclose(log.ranges, to_the_walls(poses), atol=1e-4)


@pytest.mark.parametrize("wrong", [{}, {"drift": 0.02}, {"noise": 0.01}])
def test_scans_that_were_taken_at_once_and_state_nothing_have_no_sweep(wrong: dict[str, float]) -> None:
    log = read(with_poses(at_once(0.0), **wrong))
    assert (log.time_increment, log.notes) == (0.0, ())


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
