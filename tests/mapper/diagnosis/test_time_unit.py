"""Times that are no seconds are found by the way that is driven in them, and slow or standing robots are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mapper.diagnosis import clock, examine
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog, Trajectory
from tests.mapper.diagnosis.runs import true_run

N = 60


@pytest.fixture(scope="module")
def clean() -> ScanLog:
    return true_run(N, every=3)


def retimed(log: ScanLog, factor: int) -> ScanLog:
    return replace(log, stamps_ns=(log.stamps_ns - log.stamps_ns[0]) * factor)


def test_seconds_are_not_blamed_and_thousandths_and_millionths_are(clean: ScanLog) -> None:
    assert "clock.unit" not in {finding.check for finding in examine(clean)}
    assert "clock.unit" in {finding.check for finding in examine(retimed(clean, 1_000))}
    for factor, unit in ((1_000, "milliseconds"), (1_000_000, "microseconds")):
        (found,) = clock.check_unit(retimed(clean, factor), clean.default_trajectory)
        assert found.sentence.startswith(f"The times are likely {unit} that are read as seconds")
        assert f"by {factor:,}:" in found.advice


def test_the_finding_states_the_right_interval_and_speed() -> None:
    """A metre each 2 s, as 2,000 s."""
    stamps = np.arange(N, dtype=np.int64) * 2_000_000_000_000
    (found,) = clock.check_unit(driven(stamps, 1.0), "odom")
    assert "every 2,000 s, in which the robot drives 1 m; in milliseconds these are 2 s, and 0.5 m/s." in found.sentence


def driven(stamps_ns: np.ndarray, step_m: float) -> ScanLog:
    poses = np.zeros((N, 3))
    poses[:, 0] = step_m * np.arange(N)
    return ScanLog(
        ranges=np.ones((N, 3), dtype=np.float32),
        angle_min=0.0,
        angle_increment=0.1,
        range_min=0.1,
        range_max=10.0,
        stamps_ns=stamps_ns,
        trajectories={"odom": Trajectory(poses)},
    )


@pytest.mark.parametrize(("interval_s", "step_m"), [(60, 1.0), (600, 10.0), (2, 0.01)])
def test_a_robot_that_stops_for_each_scan_or_creeps_is_not_blamed(interval_s: int, step_m: float) -> None:
    assert clock.check_unit(driven(np.arange(N, dtype=np.int64) * interval_s * 10**9, step_m), "odom") == []


def test_a_robot_that_stands_for_days_is_not_blamed() -> None:
    rng = np.random.default_rng(4)
    log = driven(np.arange(N, dtype=np.int64) * 600 * 10**9, 0.0)
    noisy = replace(log, trajectories={"odom": Trajectory(rng.normal(0.0, 0.05, (N, 3)))})
    assert clock.check_unit(noisy, "odom") == []


def test_without_times_and_without_poses_there_is_nothing_to_compare(clean: ScanLog) -> None:
    assert clock.check_unit(retimed(clean, 0), clean.default_trajectory) == []
    alone = Trajectory(clean.trajectory().poses, is_placeholder=True)
    assert clock.check_unit(replace(retimed(clean, 1_000), trajectories={"none": alone}), "none") == []


@pytest.mark.parametrize("name", ["carmen/intel.log.gz", "carmen/loop5.log.gz", "breezyslam/exp1.dat.gz"])
def test_real_logs_have_seconds(data_file: Callable[..., object], name: str) -> None:
    log = open_log(str(data_file(name)))
    for trajectory in log.trajectories:
        assert clock.check_unit(log, trajectory) == []
    if name != "carmen/loop5.log.gz":  # it has no times
        assert len(clock.check_unit(retimed(log, 1_000), log.default_trajectory)) == 1
