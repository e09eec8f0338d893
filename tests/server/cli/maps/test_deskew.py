"""Recordings of a robot that turns while its lidar sweeps, mapped and examined on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mapper.io.maps import load_map
from mapper.sensors.scan import ScanLog
from tests.mapper.io.logs import recorded
from tests.mapper.mapping.sweeping import BEAMS, off_the_walls, swept
from tests.server.cli.running import state_counts


def written(folder: Path, log: ScanLog, kind: str) -> Path:
    """A recording of the log, with tf at each scan."""
    said = [recorded.transform(int(log.stamps_ns[0]), "base_link", "laser", topic="/tf_static")]
    for stamp, ranges, (x, y, yaw) in zip(log.stamps_ns.tolist(), log.ranges, log.trajectory().poses, strict=True):
        scan = recorded.scan(stamp, ranges, angles=(log.angle_min, log.angle_increment))
        scan.fields["time_increment"] = log.time_increment
        said += [recorded.transform(stamp, "odom", "base_link", x, y, yaw), scan]
    return recorded.written(folder, said, kind)


def occupied(run, path: Path, *options: str) -> np.ndarray:
    """Distances of the occupied cells of the log's map from the walls."""
    out = path.with_name("map")
    status, _, err = run("map", path, "--scans", 38, "--quiet", "--out", out, *options)
    assert status == 0, err
    return off_the_walls(load_map(out.with_suffix(".yaml")).grid)


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_the_time_increment_of_a_recording_makes_its_map_sharp(run, tmp_path, kind):
    path = written(tmp_path, swept(), kind)
    assert np.quantile(occupied(run, path), 0.99) < 0.05
    assert np.median(occupied(run, path, "--deskew", "off")) > 0.1


def test_the_doctor_names_the_time_offset_that_puts_a_delay_right(run, tmp_path):
    path = written(tmp_path, swept(60, delay=0.2), "mcap")
    status, out, _ = run("doctor", path)
    assert status == 0
    assert "timing.delay" in out
    (found,) = [one for one in json.loads(run("doctor", path, "--json").out)["findings"] if one["parameters"]]
    offset = found["parameters"]["time_offset"]
    assert offset == pytest.approx(0.2, abs=0.06)
    assert f"--time-offset {offset:g}" in out
    assert "timing.delay" not in run("doctor", path, "--time-offset", offset).out
    assert run("check", path, "--no-findings", "timing").status == 1
    assert run("check", path, "--no-findings", "timing", "--time-offset", offset).status == 0
    wrong, right = occupied(run, path), occupied(run, path, "--time-offset", str(offset))
    assert np.mean(right) < 0.5 * np.mean(wrong), (np.mean(right), np.mean(wrong))


def test_why_tells_of_the_beams_that_the_map_is_made_of(run, tmp_path):
    path = written(tmp_path, swept(20), "mcap")
    (told,) = [json.loads(run("why", path, "--at", "3.99,0.5", "--scans", 18, "--json").out)]
    assert told["hits"] > 0
    assert all(0 <= one["beam"] < BEAMS for one in told["contributions"])


def test_the_numbers_of_deskewed_and_omitted_scans_are_printed(run, tmp_path):
    path = written(tmp_path, swept(20), "mcap")
    facts = state_counts(run, path)
    assert (facts["scans"], facts["deskewed_scans"]) == (20, 19)  # during the last sweep no pose is known
    assert "19 of the log's scans deskewed" in run("map", path).out
    shifted = state_counts(run, path, "--time-offset", "0.35")
    assert shifted["deskewed_scans"] == 15  # 16 begin before the last pose
    assert "With this time offset 4 scans are from before or after all poses, and are left out." in shifted["notes"]
    assert state_counts(run, path, "--deskew", "off")["deskewed_scans"] == 0


@pytest.mark.parametrize("option", ["--time-offset", "--deskew"])
def test_a_value_that_is_none_is_refused(run, log, option):
    status, _, err = run("map", log, option, "soon")
    assert (status, err.count("\n")) == (2, 1)
