"""``--prior`` with a map file: frames that must agree, and the notes on the map."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from tests.mapper.io.logs import recorded
from tests.mapper.io.maps.map_server import served
from tests.server.cli.running import state_counts

T0 = 1_700_000_000 * recorded.SECOND


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A recording whose poses come in both frames, ``map`` and ``odom``."""
    said = [recorded.transform(T0, "base_link", "laser", topic="/tf_static")]
    for i in range(4):
        at = T0 + i * recorded.SECOND
        said += [
            recorded.transform(at, "map", "odom", 3.0, 0.0),
            recorded.transform(at, "odom", "base_link", 0.1 * i),
            recorded.scan(at, [2.0, 2.0, 2.0]),
        ]
    return recorded.write_bag(tmp_path / "run.bag", said)


def test_a_map_file_states_its_frame_and_map_servers_can_read_it(run, recording, tmp_path):
    for name, frame in (("tf/odom", "odom"), ("tf/map", "map")):
        facts = state_counts(run, recording, "--trajectory", name, "--out", tmp_path / frame)
        assert facts["frame"] == frame
        values, keys = served(tmp_path / f"{frame}.yaml")
        assert keys["gridbloom_frame"] == frame
        assert (values == 100).sum() == facts["occupied"] > 0


def test_poses_in_another_frame_than_the_prior_map_are_refused(run, recording, tmp_path):
    known = tmp_path / "known.yaml"
    assert run("map", recording, "--trajectory", "tf/map", "--out", tmp_path / "known").status == 0
    refusal = (
        f"gridbloom: {known}: The prior map is in frame 'map', but the poses of trajectory 'tf/odom' are in frame "
        "'odom'. Choose poses in its frame with --trajectory tf/map, or state the frame of the prior map with "
        "--prior-frame odom. To find the robot in the map, run "
        f"'gridbloom localize LOG --map {known} --out poses.tum'.\n"
    )
    options = ["--trajectory", "tf/odom", "--prior", known]
    assert run("map", recording, *options) == (2, "", refusal)
    assert run("why", recording, "--at", "0,0", *options) == (2, "", refusal)
    # A map of somebody else's is taken to be in the frame `map`, as map servers publish it.
    known.write_text(known.read_text().replace("gridbloom_frame: map\n", ""))
    assert run("map", recording, *options) == (2, "", refusal)
    assert run("map", recording, *options, "--prior-frame", "odom").status == 0
    assert run("map", recording, "--trajectory", "tf/map", "--prior", known).status == 0
    status, _, err = run("map", recording, "--trajectory", "tf/map", "--prior", known, "--prior-frame", "world")
    assert status == 2
    assert "If that is wrong, state the frame of the prior map with --prior-frame map." in err


def test_an_odometry_frame_is_of_one_run_only(run, recording, tmp_path):
    options = ["--trajectory", "tf/odom"]
    assert run("map", recording, *options, "--out", tmp_path / "known").status == 0
    facts = json.loads(run("map", recording, *options, "--prior", tmp_path / "known.yaml", "--json").out)
    assert facts["notes"] == [
        "The frame 'odom' starts again with each run; the prior map must come from the run of this log."
    ]


def test_a_frame_that_the_log_does_not_state_is_noted(run, tmp_path):
    log = tmp_path / "one.csv"
    log.write_text("angle_min,0\nangle_increment,0.1\nrange_min,0\nrange_max,9\nstamp,x,y,theta,ranges\n0,0,0,0,2,2\n")
    assert state_counts(run, log, "--out", tmp_path / "known")["frame"] is None
    known = tmp_path / "known.yaml"
    assert "gridbloom_frame" not in yaml.safe_load(known.read_text())
    note = "The frame of trajectory 'scan' is not known; it is taken to be the prior map's, 'map'."
    for command in (["map", log], ["why", log, "--at", "1,0"]):
        status, out, _ = run(*command, "--prior", known)
        assert (status, out.count(f"  note: {note}\n")) == (0, 1)
        assert note not in run(*command, "--prior", known, "--prior-frame", "map").out
    assert note not in run("map", log, "--prior", known, "--quiet").out


def test_raw_carmen_odometry_does_not_go_into_a_map_of_another_frame(run, log, tmp_path):
    # In this log the poses of the FLASER lines are those of the ODOM lines.
    facts = state_counts(run, log, "--out", tmp_path / "known")
    assert facts["frame"] == "odom"
    assert run("map", log, "--prior", tmp_path / "known.yaml").status == 0
    status, _, err = run("map", log, "--prior", tmp_path / "known.yaml", "--prior-frame", "map")
    assert status == 2
    assert "in frame 'map', but the poses of trajectory 'scan' are in frame 'odom'" in err


def test_the_notes_on_a_prior_map_are_those_of_view(run, recording, tmp_path):
    known = tmp_path / "known.yaml"
    assert run("map", recording, "--trajectory", "tf/map", "--out", tmp_path / "known").status == 0
    known.write_text(known.read_text().replace("free_thresh: 0.196", "free_thresh: 0.25"))
    (note,) = [line for line in run("view", known).out.splitlines() if line.startswith("note: ")]
    options = ["--trajectory", "tf/map", "--prior", known]
    assert f"  {note}\n" in run("map", recording, *options).out
    assert f"  {note}\n" in run("why", recording, "--at", "3,0", *options).out
    assert json.loads(run("map", recording, *options, "--json").out)["notes"] == [note.removeprefix("note: ")]


def test_a_prior_frame_needs_a_map(run, log):
    refusal = "gridbloom: --prior-frame needs a map file, given with --prior.\n"
    for more in ([], ["--prior", 0.5]):
        assert run("map", log, "--prior-frame", "map", *more) == (2, "", refusal)


def test_maps_in_different_frames_are_not_merged(run, recording, tmp_path):
    for name, prefix in (("tf/map", "a"), ("tf/odom", "b")):
        assert run("map", recording, "--trajectory", name, "--out", tmp_path / prefix).status == 0
    a, b = tmp_path / "a.yaml", tmp_path / "b.yaml"
    refusal = f"gridbloom: {b}: The maps are in different frames: 'map' and 'odom'.\n"
    assert run("merge", a, b, "--out", tmp_path / "both") == (2, "", refusal)
    assert run("merge", b, b, "--out", tmp_path / "both").status == 0
    assert yaml.safe_load((tmp_path / "both.yaml").read_text())["gridbloom_frame"] == "odom"
