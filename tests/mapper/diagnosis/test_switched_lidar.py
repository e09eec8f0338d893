"""A lidar that is switched while it records, so that its scans have different beams, is examined as one sensor."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.diagnosis import Limits, diagnose, examine, first_cause, judge, named_findings
from mapper.diagnosis.events import find_events
from mapper.diagnosis.figures import map_figures
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog, by_sensor, is_measured
from mapper.sensors.scan import ScanLog, Trajectory
from tests.bench.event_runs import RATE_HZ, Happening, drive, free_scans
from tests.mapper.diagnosis.runs import true_run

N = 160


def switched(log: ScanLog, every: int = 20) -> JointLog:
    """The same scans; in every second block of them the lidar has half of its beams, in the other sense."""
    fine = np.arange(log.n_scans) // every % 2 == 0
    coarse = log.take(~fine)
    last = (log.n_beams - 1) // 2 * 2
    fewer = replace(
        coarse,
        ranges=coarse.ranges[:, last::-2].copy(),
        angle_min=log.angle_min + last * log.angle_increment,
        angle_increment=-2.0 * log.angle_increment,
    )
    parts = [log.take(fine), fewer]
    return JointLog.of([replace(part, topic="/scan", odometry=None) for part in parts])


@pytest.fixture(scope="module")
def run() -> ScanLog:
    return true_run(N, every=4)


def checks(log: ScanLog) -> list[str]:
    return [one.check for one in examine(log)]


def test_a_clean_log_has_no_finding_and_is_one_sensor(run: ScanLog) -> None:
    log = switched(run)
    ((sensor, numbers),) = by_sensor(log)
    assert sensor is log
    np.testing.assert_array_equal(numbers, np.arange(N))
    assert examine(log) == []
    assert first_cause(log, None, MappingConfig()) is None
    limits = Limits(max_drift=0.25, min_sharpness=0.5, no_findings=named_findings(["all"]))
    assert judge(log, limits, config=MappingConfig()).passed


def test_a_turned_mount_is_found_once_with_its_remedy(run: ScanLog) -> None:
    turned = switched(replace(run, mount=(0.0, 0.0, run.mount[2] - np.pi / 2)))
    (found,) = examine(turned)
    assert (found.check, found.sensor) == ("mount.turned", "")
    assert found.parameters is not None
    assert found.parameters["mount_yaw"] == pytest.approx(np.pi / 2)
    limits = Limits(max_drift=0.25, no_findings=named_findings(["all"]))
    assert not judge(turned, limits).passed
    corrected = MappingConfig().with_values(found.parameters)
    assert judge(turned, limits, config=corrected).passed, "one sensor's mount can be corrected"
    figures = map_figures(turned, None, corrected)
    assert figures.drift_m is not None
    assert figures.drift_m < 0.25


def test_beams_that_see_the_robot_are_found_at_their_bearing_in_both_resolutions(run: ScanLog) -> None:
    ranges = run.ranges.copy()
    own = np.abs(run.angles - 0.5) < 0.2
    ranges[:, own] = 0.3
    found = [one for one in examine(switched(replace(run, ranges=ranges))) if one.check == "readings.itself"]
    assert len(found) == 1
    beams, degrees = (int(one) for one in re.findall(r"(\d+) beams around (\d+)°", found[0].sentence)[0])
    assert np.count_nonzero(own) - 2 <= beams <= np.count_nonzero(own), "those at its edges are in one resolution only"
    assert degrees == pytest.approx(np.degrees(0.5), abs=np.degrees(2.0 * run.angle_increment))


def test_no_return_that_is_written_as_a_range_is_found_whatever_the_beams(run: ScanLog) -> None:
    capped = switched(replace(run, ranges=np.minimum(run.ranges, np.float32(3.0))))
    found = [one for one in examine(capped) if one.check == "readings.max_range"]
    assert [one.parameters for one in found] == [{"range_max": 2.9}]
    cause = first_cause(capped, None, MappingConfig())
    assert cause is not None
    assert cause.check == "readings.max_range"


def test_drift_delay_and_scans_that_are_missing_are_those_of_the_whole_log(run: ScanLog) -> None:
    way = run.trajectory()
    turn = np.linspace(0.0, 0.4, N)
    drifting = way.poses + np.stack([np.zeros(N), np.zeros(N), turn], axis=1)
    assert "walls.drift" in checks(switched(replace(run, trajectories={"true": Trajectory(drifting)})))
    dropped = np.ones(N, dtype=np.bool_)
    dropped[10::17] = False
    assert checks(switched(run.take(dropped))) == checks(run.take(dropped))
    seconds = run.stamps_ns * 1e-9
    late = np.stack([np.interp(seconds - 0.5, seconds, np.unwrap(column)) for column in way.poses.T], axis=1)
    (found,) = examine(switched(replace(run, trajectories={"true": Trajectory(late)})))
    assert found.check == "timing.delay"
    assert found.parameters == {"time_offset": pytest.approx(0.5, abs=0.1)}


def test_a_push_is_found_whatever_the_resolution_was(run: ScanLog) -> None:
    moved = (0.0, 0.4, 0.0)
    found = free_scans("office", 300, 4, moved)
    scan = int(found[len(found) // 2])
    log = switched(drive("office", 300, [Happening("pushed", scan, 2, moved)], seed=4), every=50)
    (event,) = find_events(log)
    assert (event.kind, event.direction) == ("pushed", "left")
    assert event.seconds == pytest.approx(scan / RATE_HZ, abs=1.0 / RATE_HZ)
    assert [one.kind for one in diagnose(log).events] == ["pushed"]


def test_limits_count_for_the_scans_of_their_own_part(run: ScanLog) -> None:
    log = switched(run)
    near = JointLog.of([replace(log.parts[0], range_max=2.0), log.parts[1]])
    counted = is_measured(near)
    assert (near.ranges[near.part_of_scan == 0][counted[near.part_of_scan == 0]] <= 2.0).all()
    assert (near.ranges[near.part_of_scan == 1][counted[near.part_of_scan == 1]] > 2.0).any()


def test_a_log_that_is_too_short_is_refused(run: ScanLog) -> None:
    with pytest.raises(ConfigError, match="A log of 8 scans is too short"):
        examine(switched(run.take(slice(0, 8)), every=4))
