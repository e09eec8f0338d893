"""``info`` of what has no scans: recordings, clouds, scan graphs, folders of depth images."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.mapper.io.clouds.test_depth_folder import seven_scenes
from tests.mapper.io.clouds.test_graph import STILL, TURNED, graph
from tests.mapper.io.contents.recorded_robot import imu
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND


def test_a_recording_without_scans_is_listed(run, tmp_path):
    said = []
    for k in range(5):
        said += [imu((k + 1) * SECOND, 0.1, 0.2, 0.3), recorded.text((k + 1) * SECOND, "hello")]
    path = recorded.written(tmp_path, said, "mcap")
    status, out, _ = run("info", path)
    assert status == 0
    assert "no scans of which a map can be made" in out
    assert "note: The log holds no scans that can be read" in out
    assert "/chatter: 5 × std_msgs/String, 1.0 Hz" in out
    assert "IMU /imu: 5 messages, frame" in out
    facts = json.loads(run("info", path, "--json").out)
    assert (facts["scans"], facts["imus"][0]["count"], len(facts["contents"])) == (0, 5, 2)
    refused = run("info", path, "--topic", "/scan")
    assert refused.status == 2
    assert "holds no scans" in refused.err
    assert run("map", path, "--out", tmp_path / "m").status == 2


def test_a_cloud_is_described(run, tmp_path):
    side = np.arange(5) * 0.25
    points = np.stack(np.meshgrid(side, side, [0.0]), axis=-1).reshape(-1, 3)
    path = tmp_path / "plane.xyz"
    path.write_text("".join(f"{x} {y} {z} 7\n" for x, y, z in points))
    status, out, _ = run("info", path)
    assert status == 0
    assert "25 points" in out
    assert "box (0.000, 0.000, 0.000) to (1.000, 1.000, 0.000): 1.00 × 1.00 × 0.00 m" in out
    assert "spacing 0.25 m" in out
    assert "intensity (float64)" in out
    facts = json.loads(run("info", path, "--json").out)
    assert (facts["points"], facts["spacing_m"], facts["high"]) == (25, pytest.approx(0.25), [1.0, 1.0, 0.0])
    path.write_text("1 2 3\n1 2\n")
    refused = run("info", path)
    assert (refused.status, "number of values changes near line" in refused.err) == (2, True)


def test_a_scan_graph_and_a_folder_of_depth_images_are_described(run, tmp_path):
    path = tmp_path / "two.graph"
    path.write_bytes(graph(STILL, TURNED))
    out = run("info", path).out
    assert "scan graph of 2 scans" in out
    assert "4 points" in out
    folder = tmp_path / "frames"
    folder.mkdir()
    seven_scenes(folder)
    out = run("info", folder).out
    assert "1 images of 3 × 2 pixels" in out
    assert "depths of the first image 1.00 to 5.00 m, 67 % of its pixels" in out
    facts = json.loads(run("info", folder, "--json").out)
    assert (facts["frames"], facts["camera"]["fy"]) == (1, 4.0)
