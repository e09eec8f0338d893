"""Two lidars whose stated mounts disagree, in simulated drives of which the true mounts are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import WorkCancelledError
from mapper.core.se2 import compose, inverse
from mapper.diagnosis import Finding, Limits, examine, judge, named_findings
from mapper.diagnosis.between import check_between
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.simulation.lidar import SensorConfig
from tests.mapper.diagnosis.runs import true_run
from tests.mapper.slam.worlds import drive

FRONT, REAR = (0.2, 0.0, 0.0), (-0.2, 0.0, math.pi)
SENSOR = SensorConfig(n_beams=120, field_of_view=1.5 * math.pi, range_max=8.0, range_noise=0.02)


@pytest.fixture(scope="module")
def path() -> np.ndarray:
    return true_run(120).trajectory("true").poses


@pytest.fixture(scope="module")
def lidars(path: np.ndarray) -> tuple[ScanLog, ScanLog]:
    """Readings of both, with their true mounts."""
    front, rear = (drive("office", path, sensor=SENSOR, mount=mount, seed=k) for k, mount in enumerate((FRONT, REAR)))
    true = {"true": front.trajectory("true")}
    return (
        replace(front, topic="/front", trajectories=true),
        replace(rear, topic="/rear", trajectories=true, stamps_ns=rear.stamps_ns + 5_000_000),
    )


def stated(lidars: tuple[ScanLog, ScanLog], error: tuple[float, float, float]) -> JointLog:
    """Their log, in which the rear one's mount has to be corrected by ``error``."""
    front, rear = lidars
    x, y, yaw = compose(inverse(np.array(error)), np.array(REAR)).tolist()
    return JointLog.of([front, replace(rear, mount=(x, y, yaw))])


def between(log: JointLog) -> list[Finding]:
    return check_between(log.parts, "true", [[], []], lambda: True)


@pytest.mark.parametrize("error", [(0.1, 0.0, 0.0), (0.0, -0.08, math.radians(1.5)), (0.15, 0.1, math.radians(-6.0))])
def test_the_mount_between_two_lidars_is_found(
    lidars: tuple[ScanLog, ScanLog], error: tuple[float, float, float]
) -> None:
    (found,) = between(stated(lidars, error))
    assert (found.check, found.sensor, found.possible) == ("mount.between", "/front + /rear", False)
    words = found.sentence.split()
    turned = float(next(word for word in words if word.endswith("°"))[:-1])
    ahead, left = (float(words[k - 1]) for k, word in enumerate(words) if word == "m")
    assert (ahead, left) == pytest.approx(error[:2], abs=0.02)
    assert turned == pytest.approx(math.degrees(error[2]), abs=0.4)
    assert "/rear sits at (-0.2" in found.advice
    assert found.parameters is None


def test_lidars_that_agree_have_no_finding_and_a_small_error_is_not_told(lidars: tuple[ScanLog, ScanLog]) -> None:
    assert between(stated(lidars, (0.0, 0.0, 0.0))) == []
    assert between(stated(lidars, (0.03, 0.0, math.radians(0.5)))) == []


def test_noise_of_the_poses_is_no_mount(lidars: tuple[ScanLog, ScanLog]) -> None:
    noise = np.random.default_rng(4).normal(0.0, 1.0, (lidars[0].n_scans, 3)) * [0.03, 0.03, 0.02]
    way = lidars[0].trajectory("true")
    noisy = {"true": replace(way, poses=way.poses + noise)}
    both = (replace(lidars[0], trajectories=noisy), replace(lidars[1], trajectories=noisy))
    assert between(stated(both, (0.0, 0.0, 0.0))) == []


def test_sensors_with_findings_that_spoil_it_are_left_out_and_it_can_be_cancelled(
    lidars: tuple[ScanLog, ScanLog],
) -> None:
    log = stated(lidars, (0.1, 0.0, 0.0))
    assert check_between(log.parts, "true", [[], [Finding("mount.turned", "", "", 0.9)]], lambda: True) == []
    with pytest.raises(WorkCancelledError):
        check_between(log.parts, "true", [[], []], lambda: False)


def test_the_examination_and_a_verdict_name_both(lidars: tuple[ScanLog, ScanLog]) -> None:
    log = stated(lidars, (0.1, 0.0, 0.0)).take(slice(0, 120))
    verdict = judge(log, Limits(no_findings=named_findings(["mount.between"])))
    assert [(one.check, one.sensor) for one in verdict.reasons] == [("mount.between", "/front + /rear")]
    assert verdict.findings is not None
    assert [one.sensor for one in verdict.findings if one.check == "mount.between"] == ["/front + /rear"]
    assert examine(log) == list(verdict.findings)
