"""``check`` judges a log by limits: exit status 0, 1 with the reasons, or 2."""

from __future__ import annotations

import json

import pytest

from tests.server.cli.maps.test_drift import run_of_a_robot

__all__ = ["run_of_a_robot"]  # a fixture

LIMITS = ["--max-drift", "0.17", "--min-sharpness", "0.67", "--no-findings", "mount, walls.drift"]


def test_a_log_within_the_limits_exits_with_status_0(run, run_of_a_robot):
    status, out, err = run("check", run_of_a_robot, *LIMITS)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert out.startswith("robot.log: passed, drift 0.")


def test_a_log_that_does_not_is_status_1_with_a_line_for_each_reason(run, run_of_a_robot):
    options = [*LIMITS, "--trajectory", "wheel", "--possible"]
    status, out, err = run("check", run_of_a_robot, *options, "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (1, "", 1)
    assert (facts["log"], facts["trajectory"], facts["passed"]) == ("robot.log", "wheel", False)
    checks = [reason["check"] for reason in facts["reasons"]]
    assert checks == ["drift", "sharpness", "walls.drift"]
    assert facts["reasons"][0]["measured"] == facts["drift_m"] > facts["reasons"][0]["limit"] == 0.17
    status, out, err = run("check", run_of_a_robot, *options)
    assert (status, err, out.count("\n")) == (1, "", 1 + len(checks))
    assert out.startswith(f"robot.log: failed, drift {facts['drift_m']:.2f} m, sharpness ")
    for reason, line in zip(facts["reasons"], out.splitlines()[1:], strict=True):
        assert line == f"  {reason['check']}: {reason['sentence']}"


def test_a_mount_that_is_wrong_fails(run, run_of_a_robot):
    status, out, _ = run("check", run_of_a_robot, "--no-findings", "mount", "--mount", "0,0,1.5708")
    assert (status, "mount.turned: " in out) == (1, True)
    status, out, _ = run("check", run_of_a_robot, "--min-sharpness", "0.5", "--mount-upside-down", "--json")
    assert status == 1
    assert json.loads(out)["findings"] is None


BAD = {
    "nothing to check": ([], "Nothing to check: give --max-drift, --min-sharpness or --no-findings."),
    "negative drift": (["--max-drift", "-1"], "--max-drift needs a number of metres from 0, not -1."),
    "drift of nan": (["--max-drift", "nan"], "--max-drift needs a number of metres from 0, not nan."),
    "sharpness above 1": (["--min-sharpness", "1.5"], "--min-sharpness needs a number from 0 to 1, not 1.5."),
    "no such finding": (
        ["--no-findings", "clock,wheels"],
        "--no-findings: There is no finding 'wheels'; there are all",
    ),
    "empty name": (["--no-findings", ""], "--no-findings: There is no finding ''"),
    "no such poses": (["--max-drift", "1", "--trajectory", "slam"], "the log has no trajectory 'slam'"),
    "bad mount": (["--max-drift", "1", "--mount", "1"], "--mount needs three numbers"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_options_print_one_sentence_and_exit_with_status_2(run, run_of_a_robot, case):
    options, words = BAD[case]
    status, out, err = run("check", run_of_a_robot, *options)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert words.lower() in err.lower()


def test_a_log_that_cannot_be_judged_is_status_2(run, log, tmp_path):
    gone = tmp_path / "gone.log"
    assert run("check", gone, *LIMITS, "--json") == (2, "", f"gridbloom: {gone}: There is no file 'gone.log'.\n")
    status, out, err = run("check", log, *LIMITS)
    assert (status, out) == (2, "")
    assert "too short to judge" in err


@pytest.mark.long  # a simulated run is judged above
def test_a_corrected_log_passes_and_its_raw_odometry_fails(run, data_file):
    options = ["--max-drift", "0.3", "--min-sharpness", "0.45", "--no-findings", "mount,poses,walls"]
    assert run("check", data_file("carmen/intel-corrected.log.gz"), *options).status == 0
    status, out, _ = run("check", data_file("carmen/intel.log.gz"), *options)
    assert status == 1
    assert [line.split(":")[0].strip() for line in out.splitlines()[1:]] == ["drift", "sharpness", "walls.drift"]
