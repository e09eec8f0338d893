"""A log of two lidars: each is examined, and findings and reasons name theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.diagnosis import Finding, Limits, examine, judge, named_findings
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from tests.mapper.diagnosis.runs import true_run

N = 160


@pytest.fixture(scope="module")
def front() -> ScanLog:
    return replace(true_run(N, every=4), topic="/front")


def other(log: ScanLog, mount: tuple[float, float, float]) -> ScanLog:
    """The scans of another lidar, a moment later, whose mount is stated rightly: its base is where the first's is."""
    way = log.trajectory()
    bases = replace(way, poses=compose(compose(way.poses, np.array(log.mount)), inverse(np.array(mount))))
    return replace(log, topic="/rear", mount=mount, stamps_ns=log.stamps_ns + 1_000, trajectories={"true": bases})


def seen(findings: list[Finding]) -> set[tuple[str, str]]:
    return {(one.sensor, one.check) for one in findings}


def test_a_sensor_that_is_mounted_backwards_is_named_and_the_other_is_not(front: ScanLog) -> None:
    rear = replace(other(front, (0.0, 0.0, 0.0)), mount=(0.0, 0.0, np.pi / 2))
    said: list[float] = []
    found = examine(JointLog.of([front, rear]), progress=said.append)
    assert seen(found) == {("/rear", "mount.turned")}
    assert said == sorted(said)
    assert (said[0], max(said) < 1.0) == (0.0, True)
    alone = examine(rear)
    assert (found[0].sentence, found[0].sure) == (alone[0].sentence, alone[0].sure)
    assert alone[0].parameters is not None
    assert found[0].parameters is None, "the other sensor's mount would be turned as well"
    assert found[0].advice.endswith("map this one by itself with such a value.")


def test_what_all_sensors_need_keeps_its_parameters_and_scans_are_those_of_the_joint_log(front: ScanLog) -> None:
    capped = replace(front, ranges=np.minimum(front.ranges, np.float32(3.0)))
    both = JointLog.of([capped, other(capped, (0.1, 0.0, 0.2))])
    found = examine(both)
    assert seen(found) >= {("/front", "readings.max_range"), ("/rear", "readings.max_range")}
    for one in found:
        if one.check == "readings.max_range":
            assert one.parameters == {"range_max": 2.9}
            assert {both.parts[both.part_of_scan[scan]].topic for scan in one.scans} == {one.sensor}
            assert all((both.ranges[scan] == np.float32(3.0)).any() for scan in one.scans)


def test_a_sensor_with_few_scans_is_said_and_the_other_is_examined(front: ScanLog) -> None:
    short = other(front, (0.0, 0.0, 0.0)).take(slice(0, 4))
    found = examine(JointLog.of([front, short]))
    assert seen(found) == {("/rear", "readings.few")}
    assert found[0].sentence == "Only 4 scans: too few to judge."
    with pytest.raises(ConfigError, match="A log of 4 scans is too short"):
        examine(JointLog.of([front.take(slice(0, 3)), short]))


def test_a_verdict_names_the_sensor_that_fails(front: ScanLog) -> None:
    rear = other(front, (0.1, 0.0, 0.3))
    limits = Limits(max_drift=0.25, min_sharpness=0.6, no_findings=named_findings(["mount"]))
    passed = judge(JointLog.of([front, rear]), limits)
    assert passed.passed
    assert passed.drift is not None
    turned = replace(rear, mount=(0.1, 0.0, 0.3 + np.pi / 2))
    verdict = judge(JointLog.of([front, turned]), limits)
    assert {(one.sensor, one.check) for one in verdict.reasons} == {
        ("/rear", "drift"), ("/rear", "mount.turned"), ("", "sharpness"),
    }  # fmt: skip
    assert verdict.sharpness is not None
    assert passed.sharpness is not None
    assert verdict.sharpness < passed.sharpness
    assert seen(list(verdict.findings or ())) == {("/rear", "mount.turned")}
    with pytest.raises(ConfigError, match="for one sensor"):
        judge(JointLog.of([front, rear]), limits, config=MappingConfig(mount_yaw=0.1))
    with pytest.raises(ConfigError, match="/rear: A log of 4 scans is too short"):
        judge(JointLog.of([front, rear.take(slice(0, 4))]), limits)
