"""Sonars on several topics, and scans cut out of clouds, mapped on the command line."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from mapper.io.export import write_mcap
from mapper.sensors.joint_log import JointLog
from mapper.simulation import sample_log
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import transform
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.server.cli.running import Run, state_counts


def test_all_sonars_make_one_map_where_there_is_no_lidar(run: Run, tmp_path: Path) -> None:
    bearings = [-1.0, 0.0, 1.0]
    said = [
        transform(recorded.SECOND, "base_link", f"sonar{n}", 0.1 * n, 0.0, bearing, topic="/tf_static")
        for n, bearing in enumerate(bearings)
    ]
    for i in range(1, 6):
        at = i * recorded.SECOND
        said.append(transform(at, "odom", "base_link", 0.1 * i))
        said += [recorded.sonar(at + n, 2.0, f"/sonar/{n}", f"sonar{n}") for n in range(3)]
    path = recorded.written(tmp_path, said, "bag")
    facts = state_counts(run, path)
    assert [one["topic"] for one in facts["sensors"]] == ["/sonar/0", "/sonar/1", "/sonar/2"]
    alone = [state_counts(run, path, "--topic", f"/sonar/{n}") for n in range(3)]
    assert facts["cells_updated"] == sum(one["cells_updated"] for one in alone)
    assert any("one of 3 sonars, which make one map" in note for note in facts["notes"])


def test_a_cloud_is_mapped_and_the_height_band_chooses_its_points(run: Run, tmp_path: Path) -> None:
    path = recorded.written(tmp_path, recording_of_room(), "mcap")
    walls = state_counts(run, path, "--min-height", "0.1", "--max-height", "2", "--angle-increment", "0.02")
    assert (walls["scans"], walls["beams"]) == (4, 315)
    assert walls["occupied"] > 100
    assert state_counts(run, path, "--min-height", "2.6", "--max-height", "3")["occupied"] == 0
    for options, said in (
        (("--min-height", "3", "--max-height", "2"), "least height must be below the greatest"),
        (("--angle-increment", "soon"), "must be a finite number"),
    ):
        status, _, err = run("map", path, *options)
        assert (status, err.count("\n")) == (2, 1)
        assert said in err


@pytest.fixture(scope="module")
def two_lidars(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of two lidars, of which the second is mounted a quarter of a turn off what tf says."""
    log = sample_log(120)
    thinned = replace(log, ranges=log.ranges[:, ::4].copy(), angle_increment=4.0 * log.angle_increment)
    front = replace(thinned, trajectories={"true": log.trajectory("true")}, topic="/front", frame_id="front")
    turned = replace(
        front, topic="/rear", frame_id="rear", mount=(0.0, 0.0, math.pi / 2), stamps_ns=front.stamps_ns + 1_000
    )
    path = tmp_path_factory.mktemp("two") / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, JointLog.of([front, turned]))
    return path


def test_doctor_and_check_examine_every_sensor_that_is_named(run: Run, two_lidars: Path) -> None:
    both = ("--topic", "/front", "--topic", "/rear")
    out = run("doctor", two_lidars, *both).out
    assert "mount.turned of /rear (" in out
    assert "/front" not in out
    status, out, _ = run("check", two_lidars, *both, "--no-findings", "mount")
    assert (status, "  mount.turned of /rear: The laser fits much better" in out) == (1, True)
    status, out, _ = run("check", two_lidars, "--topic", "/front", "--no-findings", "mount", "--json")
    assert (status, json.loads(out)["findings"]) == (0, [])
    status, _, err = run("check", two_lidars, *both, "--no-findings", "mount", "--mount", "0,0,1")
    assert (status, "A correction of the mount is for one sensor" in err) == (2, True)


def test_map_exports_the_scans_of_all_sensors(run: Run, two_lidars: Path, tmp_path: Path) -> None:
    both = ("--topic", "/front", "--topic", "/rear", "--quiet")
    facts = state_counts(run, two_lidars, *both, "--mcap", tmp_path / "out.mcap", "--tum", tmp_path / "out.tum")
    with AnyReader([tmp_path / "out.mcap"]) as reader:
        counts = {one.topic: one.msgcount for one in reader.connections}
    assert (counts["/front"], counts["/rear"], counts["/pose"]) == (120, 120, 240)
    assert len((tmp_path / "out.tum").read_text().splitlines()) == facts["scans"] == 240
    again = state_counts(run, tmp_path / "out.mcap", *both)
    assert (again["cells_updated"], again["occupied"]) == (facts["cells_updated"], facts["occupied"])
