"""``info`` and ``doctor``: their output."""

from __future__ import annotations

import json

import numpy as np

from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recording.test_streams import run as streams


def test_info_prints_the_contents_of_a_log(run, log):
    status, out, err = run("info", log)
    assert (status, err) == (0, "")
    assert "4 scans of 180 beams over 179.0°, 3.0 s" in out
    assert "716 readings measured, 4 without return, 0 invalid" in out
    assert "trajectory scan:" in out
    assert "trajectory wheel:" in out


def test_info_as_json_is_one_object_and_nothing_else(run, log):
    status, out, err = run("info", log, "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert (facts["scans"], facts["beams"], facts["duration_s"]) == (4, 180, 3.0)
    assert facts["readings"] == {"measured": 716, "no_return": 4, "invalid": 0}
    assert [trajectory["name"] for trajectory in facts["trajectories"]] == ["scan", "wheel"]


def test_info_lists_the_topics_of_a_recording_and_map_selects_one(run, tmp_path):
    at = 1_700_000_000 * recorded.SECOND
    said = [recorded.scan(at + i, [2.0, 3.0], "/front", "front") for i in range(3)]
    said += [recorded.scan(at + i * recorded.SECOND, [4.0], "/rear", "rear") for i in range(2)]
    path = recorded.write_bag(tmp_path / "run.bag", said)
    status, out, _ = run("info", path)
    assert status == 0
    assert "from 2023-11-14 22:13:20 UTC" in out
    assert "* /front: 3 × sensor_msgs/LaserScan, 2 beams over 5.7°" in out
    assert "  /rear: 2 × sensor_msgs/LaserScan, 1 beam over 0.0°, 1.0 Hz, frame rear" in out
    size = len(recorded.serialised(said[-1], 1))
    assert f"frame rear, {2 * size} B in 1.0 s" in out
    assert "B in" not in run("info", path, "--no-contents").out
    assert json.loads(run("info", path, "--json").out)["contents"][1]["bytes"] == 2 * size
    assert "the file holds no poses" in out.lower()
    rear = json.loads(run("info", path, "--topic", "/rear", "--json").out)
    assert (rear["scans"], rear["topics"][1]["chosen"]) == (2, True)
    assert json.loads(run("map", path, "--topic", "/rear", "--json").out)["scans"] == 2
    status, _, err = run("map", path, "--topic", "/left")
    assert (status, err.count("\n")) == (2, 1)
    assert "'/left'; it has /front, /rear" in err


def test_info_says_what_the_clouds_and_imus_of_a_recording_are(run, tmp_path):
    path = recorded.written(tmp_path, streams(), "mcap")
    status, out, _ = run("info", path)
    assert status == 0
    fields = "x, y, z, intensity, ring, t"
    at = "frame velodyne at 0.2, 0.1, 1 m"
    assert f"  clouds /points: 8 of 25 × 4 points ({fields}), a time for each point, {at}\n" in out
    assert "  IMU /imu: 8 messages, frame imu, with orientation\n" in out
    facts = json.loads(run("info", path, "--json").out)
    assert facts["clouds"][0]["mount"] == [0.2, 0.1, 1.0]
    assert [one["topic"] for one in facts["imus"]] == ["/imu"]


def test_the_doctor_prints_its_findings(run, tmp_path):
    # A robot that turns in a square room, whose laser is said to look backwards.
    lines = ["PARAM robot_frontlaser_offset 0.0"]
    for t in range(40):
        yaw = 0.15 * t
        angles = yaw + np.radians(np.arange(180) - 90.0) + np.pi
        ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
        pose = f"{0.01 * t} 0 {yaw}"
        readings = " ".join(f"{r:.3f}" for r in ranges)
        lines.append(f"FLASER 180 {readings} {pose} {pose} {0.2 * t:.3f} robot {0.2 * t:.3f}")
    path = tmp_path / "backwards.log"
    path.write_text("\n".join(lines) + "\n")
    facts = json.loads(run("doctor", path, "--json").out)
    assert facts["log"] == "backwards.log"
    status, out, _ = run("doctor", path)
    assert status == 0
    assert f"{len(facts['findings'])} finding" in out
    for finding in facts["findings"]:
        assert finding["sentence"] in out
        assert finding["possible"] == (finding["sure"] < 0.7)
        assert (f"{finding['check']} (possible, " in out) == finding["possible"]
        assert finding["advice"] in out
    short = tmp_path / "short.log"
    short.write_text(lines[1] + "\n")
    status, out, err = run("doctor", short)
    assert (status, out) == (2, "")
    assert "too short to judge" in err
