"""Frames and times of a recording in the exported file, read with rosbags and with ours."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from mapper.io.export import write_mcap
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog
from tests.mapper.io.export.exported import map_of, read
from tests.mapper.io.logs.recorded import KINDS, SECOND, Said, estimate, odometry, scan, transform, written


@pytest.mark.parametrize("kind", KINDS)
def test_frames_and_times_of_a_recording_are_kept(tmp_path: Path, kind: str) -> None:
    step = SECOND // 10
    messages = [transform(0, "base_footprint", "front_laser", 0.3, 0.1, 0.2, topic="/tf_static")]
    for i in range(12):
        said = scan(i * step, np.full(31, 4.0), frame="front_laser")
        said.fields.update(time_increment=0.00017, scan_time=0.1)
        messages += [transform(i * step, "odom", "base_footprint", 0.1 * i, 0.0, 0.02 * i), said]
    recorded = open_log(written(tmp_path, messages, kind))
    assert recorded.frame_id == "front_laser"
    assert (recorded.time_increment, recorded.scan_time) == pytest.approx((0.00017, 0.1), rel=1e-6)
    path = tmp_path / "out.mcap"
    with path.open("wb") as file:
        write_mcap(file, recorded, map_of(recorded)[1])
    found = read(path)
    (scan_0, *_), (tf, *_), (static,) = ([one for _, one in found[name]] for name in ("/scan", "/tf", "/tf_static"))
    assert scan_0.header.frame_id == "front_laser"
    assert (scan_0.time_increment, scan_0.scan_time) == pytest.approx((0.00017, 0.1), rel=1e-6)
    assert [(one.header.frame_id, one.child_frame_id) for one in tf.transforms] == [("odom", "base_footprint")]
    assert [(one.header.frame_id, one.child_frame_id) for one in static.transforms] == [
        ("base_footprint", "front_laser")
    ]
    assert {one.header.frame_id for _, one in (*found["/map"], *found["/pose"])} == {"odom"}
    again = open_log(path)
    assert list(again.trajectories) == ["tf/odom"]
    np.testing.assert_allclose(again.mount, recorded.mount, atol=1e-9)
    with path.open("rb") as file:
        frames = {
            message.header.frame_id: message.time_increment
            for _, channel, _, message in make_reader(
                file, decoder_factories=[DecoderFactory()]
            ).iter_decoded_messages()
            if channel.topic == "/scan"
        }
    assert frames == {"front_laser": pytest.approx(0.00017, rel=1e-6)}


@pytest.mark.parametrize(("pose", "parent"), [(odometry, "odom"), (estimate, "map")])
def test_poses_of_a_topic_keep_their_frame(tmp_path: Path, pose: Callable[..., Said], parent: str) -> None:
    messages = []
    for i in range(5):
        messages += [pose(i * SECOND, 0.1 * i, 0.0, 0.0), scan(i * SECOND, np.full(31, 4.0))]
    path = tmp_path / "out.mcap"
    with path.open("wb") as file:
        write_mcap(file, open_log(written(tmp_path, messages, "mcap")))
    found = read(path)
    (edge,) = found["/tf"][0][1].transforms
    assert (edge.header.frame_id, edge.child_frame_id) == (parent, "base_link")
    (mount,) = found["/tf_static"][0][1].transforms
    assert (mount.header.frame_id, mount.child_frame_id) == ("base_link", "laser")


@pytest.mark.parametrize("has_mount", [False, True])
def test_a_log_without_poses_gets_no_transform_that_it_did_not_state(tmp_path: Path, has_mount: bool) -> None:
    messages = [scan(i * SECOND, np.full(31, 4.0)) for i in range(5)]
    if has_mount:
        messages.insert(0, transform(0, "base_link", "laser", 0.3, topic="/tf_static"))
    recorded = open_log(written(tmp_path, messages, "mcap"))
    path = tmp_path / "out.mcap"
    with path.open("wb") as file:
        write_mcap(file, recorded, map_of(recorded)[1])
    found = read(path)
    assert set(found) == {"/map", "/scan", "/points"} | ({"/tf_static"} if has_mount else set())
    # What the map was made in is where the viewer puts it: the mount alone lies between map and scan.
    assert found["/map"][0][1].header.frame_id == ("base_link" if has_mount else "laser")
    again = open_log(path)
    np.testing.assert_allclose(again.mount, (0.3 if has_mount else 0.0, 0.0, 0.0), atol=1e-9)
    assert again.trajectory().is_placeholder


@pytest.mark.parametrize(("name", "parent"), [("true", "map"), ("odometry", "odom")])
def test_odometry_is_stated_from_odom(tmp_path: Path, log: ScanLog, name: str, parent: str) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, map_of(log)[1], name)
    found = read(path)
    (edge,) = found["/tf"][3][1].transforms
    assert (edge.header.frame_id, edge.child_frame_id) == (parent, "base_link")
    assert found["/map"][0][1].header.frame_id == found["/pose"][0][1].header.frame_id == parent


@pytest.mark.parametrize("stated", [math.nan, math.inf, 1e30])
def test_invalid_times_are_left_out(tmp_path: Path, stated: float) -> None:
    said = [scan(i * SECOND, np.full(31, 4.0)) for i in range(3)]
    for one in said:
        one.fields.update(time_increment=stated, scan_time=stated)
    log = open_log(written(tmp_path, said, "mcap"))
    assert (log.time_increment, log.scan_time) == (0.0, 0.0)
