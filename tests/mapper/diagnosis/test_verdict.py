"""Limits on a log: judged against simulated truth, and real logs that are corrected and raw."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.diagnosis import Limits, between, examine, judge, mounting, named_findings, sparse, sweep, timing
from mapper.diagnosis.consistency import Contradiction
from mapper.diagnosis.verdict import FINDINGS
from mapper.io.logs import open_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.odometry import ALPHAS, TURN_BIAS, drifting_odometry
from tests.bench.doctor import part
from tests.mapper.diagnosis.runs import true_run
from tests.marks import also_long

N = 300
STRICT = Limits(max_drift=0.25, min_sharpness=0.6, no_findings=frozenset(FINDINGS), possible=True)


@pytest.fixture(scope="module")
def clean() -> ScanLog:
    return true_run(N, every=3)


def with_poses(log: ScanLog, poses: np.ndarray) -> ScanLog:
    return replace(log, trajectories={"bad": Trajectory(poses)})


def drifting(log: ScanLog, scale: float = 4.0) -> ScanLog:
    alphas = (scale * ALPHAS[0], scale * ALPHAS[1], scale * ALPHAS[2], scale * ALPHAS[3])
    rng = np.random.default_rng(3)
    return with_poses(log, drifting_odometry(log.trajectory().poses, rng, alphas, scale * TURN_BIAS))


def reasons(log: ScanLog, limits: Limits, config: MappingConfig | None = None) -> set[str]:
    return {reason.check for reason in judge(log, limits, config=config).reasons}


def test_a_clean_log_keeps_strict_limits(clean: ScanLog) -> None:
    verdict = judge(clean, STRICT)
    assert verdict.passed
    assert verdict.findings == ()
    assert verdict.public()["reasons"] == []


@pytest.mark.parametrize("shift", [0.6, *also_long(0.4, 0.8)])
def test_drift_is_the_distance_between_the_two_copies_of_a_wall(clean: ScanLog, shift: float) -> None:
    """The second half is shifted along both axes of a building whose walls run along them."""
    poses = clean.trajectory().poses.copy()
    poses[N // 2 :, :2] += shift
    verdict = judge(with_poses(clean, poses), Limits(max_drift=0.25))
    assert verdict.drift is not None
    assert verdict.drift == pytest.approx(shift, abs=0.15)
    (reason,) = verdict.reasons
    assert (reason.check, reason.measured, reason.limit) == ("drift", verdict.drift, 0.25)
    assert f"within {verdict.drift:.2f} m of the walls that were seen" in reason.sentence
    assert reason.sentence.endswith("the limit is 0.25 m.")
    assert judge(with_poses(clean, poses), Limits(max_drift=round(verdict.drift, 2))).passed, "as it is stated"


def test_odometry_that_drifts_fails_with_its_reasons(clean: ScanLog) -> None:
    assert reasons(drifting(clean), STRICT) >= {"drift", "walls.drift"}
    assert reasons(drifting(clean), Limits(max_drift=5.0, no_findings=named_findings(["clock", "mount"]))) == set()


def test_poses_that_tremble_smear_the_walls(clean: ScanLog) -> None:
    noise = np.random.default_rng(3).normal(0.0, (0.1, 0.1, 0.02), (N, 3))
    smeared = with_poses(clean, compose(clean.trajectory().poses, noise))
    (reason,) = judge(smeared, Limits(min_sharpness=0.6)).reasons
    assert reason.check == "sharpness"
    assert reason.measured is not None
    assert 0.0 < reason.measured < 0.6
    assert reason.sentence == f"The sharpness of the walls is {reason.measured:.3f}; the limit is 0.600."


def test_correcting_the_mount_removes_its_finding(clean: ScanLog) -> None:
    backwards = replace(clean, mount=(0.0, 0.0, np.pi / 2), upside_down=not clean.upside_down)
    verdict = judge(backwards, STRICT)
    assert {"mount.turned", "drift", "sharpness"} <= {reason.check for reason in verdict.reasons}
    (drift,) = [reason for reason in verdict.reasons if reason.check == "drift"]
    assert drift.measured is None
    assert "was found" in drift.sentence
    assert "walls.drift" not in reasons(backwards, STRICT), "mount.turned is a reason already"
    assert judge(backwards, STRICT, config=MappingConfig(mount_yaw=-np.pi / 2, mount_upside_down=True)).passed


def test_a_check_that_could_not_run_does_not_pass(clean: ScanLog) -> None:
    few = replace(clean, ranges=clean.ranges[:, :1].copy())
    assert reasons(few, Limits(no_findings=named_findings(["walls"]))) == {"walls.drift", "walls.moving"}
    assert reasons(few, Limits(no_findings=named_findings(["clock"]))) == set()
    still = with_poses(clean, np.repeat(clean.trajectory().poses[:1], N, axis=0))
    for log, why in ((still, "poses stay in one place"), (replace(clean, beam_width=0.2), "too wide")):
        (reason,) = judge(log, Limits(max_drift=1.0)).reasons
        assert reason.measured is None
        assert why in reason.sentence
    with pytest.raises(ConfigError, match="too short"):
        judge(part(clean, "true", 0, 5), STRICT)
    with pytest.raises(ConfigError, match="no trajectory"):
        judge(clean, Limits(min_sharpness=0.1), "slam")


def test_possible_findings_count_only_on_request(clean: ScanLog) -> None:
    unsure = drifting(clean, 1.0)
    verdict = judge(unsure, Limits(no_findings=named_findings(["walls"])))
    (drift,) = verdict.findings or ()
    assert (drift.check, drift.possible, verdict.reasons) == ("walls.drift", True, ())
    assert reasons(unsure, Limits(no_findings=named_findings(["walls"]), possible=True)) == {"walls.drift"}


def test_names_of_findings() -> None:
    assert named_findings(["all"]) == set(FINDINGS)
    assert named_findings(["mount", "walls.drift"]) == {
        "mount.turned",
        "mount.offset",
        "mount.between",
        "mount.changing",
        "walls.drift",
    }
    for wrong in ("wall", "walls.", "", "walls.drift.x", "ALL"):
        with pytest.raises(ConfigError, match=r"there are all, clock\.backwards, .*walls\.moving, mount\.between\."):
            named_findings(["mount", wrong])


def test_every_finding_that_the_checks_can_make_has_its_name_in_the_list() -> None:
    folder = Path(__file__).parents[3] / "mapper" / "diagnosis"
    source = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.py"))
    made = set(re.findall(r'\bFinding\(\s*"([a-z_.]+)"', source)) | {
        "readings.few",
        between.CHECK,
        mounting.CHANGING,
        sparse.CHECK,
        sweep.CHECK,
        timing.CLOCK,
    }
    assert made == set(FINDINGS)


def test_the_drift_measurement_is_returned_without_a_finding_too(clean: ScanLog) -> None:
    compared: list[Contradiction] = []
    assert examine(clean, compared=compared.append) == []
    (one,) = compared
    assert one.excess < 0.05
    offset = one.offset()
    assert offset is not None
    assert 0.0 <= offset <= 0.2


@pytest.mark.parametrize("name", ["intel", *also_long("aces", "fhw")])
def test_real_logs_pass_corrected_and_fail_raw(data_file: Callable[..., object], name: str) -> None:
    limits = Limits(max_drift=0.25, min_sharpness=0.45, no_findings=named_findings(["mount", "poses", "walls"]))
    log = open_log(str(data_file(f"carmen/{name}-corrected.log.gz")))
    assert judge(log, limits, "scan").passed
    assert {reason.check for reason in judge(log, limits, "wheel").reasons} == {"drift", "sharpness", "walls.drift"}
