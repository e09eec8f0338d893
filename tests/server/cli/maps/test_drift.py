"""``map`` says on one line that the poses drift."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mapper.simulation import sample_log
from mapper.simulation.odometry import drifting_odometry


@pytest.fixture(scope="module")
def run_of_a_robot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A CARMEN log of a simulated robot: true poses with its scans, odometry that drifts in its ODOM lines."""
    log = sample_log(300)
    true = log.trajectory("true").poses
    odometry = drifting_odometry(true, np.random.default_rng(3))
    beams = f"{log.angle_min} {log.angle_increment * log.n_beams} {log.angle_increment} {log.range_max} 0.01 0"
    lines = []
    for k in range(log.n_scans):
        # What exceeds the greatest range is no return.
        readings = " ".join(f"{r:.3f}" for r in np.nan_to_num(log.ranges[k], nan=0.0, posinf=log.range_max + 1.0))
        pose, wheels = (" ".join(f"{v:.6f}" for v in poses[k]) for poses in (true, odometry))
        lines += [
            f"ODOM {wheels} 0 0 0 {k / 5} host {k / 5}",
            f"ROBOTLASER1 0 {beams} {log.n_beams} {readings} 0 {pose} {pose} 0 0 0 0 0 {k / 5} host {k / 5}",
        ]
    path = tmp_path_factory.mktemp("drift") / "robot.log"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_drift_is_said_on_one_line_with_its_remedy(run, run_of_a_robot):
    options = ["--trajectory", "wheel"]
    line = (
        "The poses of trajectory 'wheel' drift, so walls may be double: try other poses of this log with "
        "--trajectory scan, or correct them with gridbloom slam."
    )
    status, out, err = run("map", run_of_a_robot, *options)
    assert (status, err) == (0, "")
    assert [one for one in out.splitlines() if "drift" in one] == [f"  note: {line}"]
    assert json.loads(run("map", run_of_a_robot, *options, "--json").out)["drift"] == line
    assert json.loads(run("map", run_of_a_robot, "--json").out)["drift"] is None


def test_quiet_maps_without_the_check_and_without_notes(run, run_of_a_robot, monkeypatch):
    def examined(*_: object) -> None:
        pytest.fail("the poses were examined")

    monkeypatch.setattr("server.cli.maps.map_log.first_cause", examined)
    status, out, _ = run("map", run_of_a_robot, "--trajectory", "wheel", "--quiet")
    assert (status, "note" in out) == (0, False)
    assert "drift" not in json.loads(run("map", run_of_a_robot, "-q", "--json").out)


@pytest.mark.parametrize("name", ["intel", "aces", "fhw"])
def test_corrected_poses_of_real_logs_are_not_called_drifted(run, data_file, name):
    path = data_file(f"carmen/{name}-corrected.log.gz")
    assert json.loads(run("map", path, "--json").out)["drift"] is None


def test_the_same_poses_from_another_source_are_no_remedy(run, data_file):
    # In this raw log the FLASER lines repeat the odometry.
    drift = json.loads(run("map", data_file("carmen/aces.log.gz"), "--json").out)["drift"]
    assert "drift" in drift
    assert "correct them with gridbloom slam; the log has no different ones" in drift
