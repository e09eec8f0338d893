"""Exported files, read with independent readers (rosbags, mcap, mcap-ros2-support) and with ours."""

from __future__ import annotations

import io
import math
import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.io.export import GrowingMap, tum_text, write_mcap
from mapper.io.export.growing_map import MOST_CELLS, MOST_MAPS, scans_with_a_map
from mapper.io.export.recording import LAST_STAMP_NS, export_stamps
from mapper.io.logs import open_log
from mapper.io.maps import occupancy_values
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.mapping.scan_batch import placed_scan
from mapper.sensors.scan import ScanLog
from tests.mapper.io.export.exported import map_of, read, sonars_of
from tests.mapper.mapping.sweeping import swept


def test_another_reader_finds_the_map_the_poses_and_the_scans(tmp_path: Path, log: ScanLog) -> None:
    grid, growing = map_of(log)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, growing, "true")
    found = read(path)
    assert {topic: len(messages) for topic, messages in found.items()} == {
        "/map": MOST_MAPS, "/tf_static": 1,
        "/tf": log.n_scans, "/pose": log.n_scans, "/scan": log.n_scans, "/points": log.n_scans,
    }  # fmt: skip
    assert found["/map"][0][0] == log.stamps_ns[0]
    at, occupancy = found["/map"][-1]
    assert at == log.stamps_ns[-1]
    assert (occupancy.info.height, occupancy.info.width) == grid.geometry.shape
    assert occupancy.info.resolution == pytest.approx(0.1)
    assert (occupancy.info.origin.position.x, occupancy.info.origin.position.y) == grid.geometry.origin[:2]
    np.testing.assert_array_equal(occupancy.data.reshape(grid.geometry.shape), occupancy_values(grid))
    assert occupancy.header.frame_id == "map"
    poses = log.trajectory("true").poses
    for index in (0, 7, log.n_scans - 1):
        stamp, scan = found["/scan"][index]
        assert stamp == scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec == log.stamps_ns[index]
        np.testing.assert_array_equal(scan.ranges, log.ranges[index])
        assert scan.angle_max == pytest.approx(log.angle_min + log.angle_increment * (log.n_beams - 1), abs=1e-5)
        pose = found["/pose"][index][1].pose
        assert (pose.position.x, pose.position.y) == tuple(poses[index, :2])
        yaw = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        assert math.cos(yaw - poses[index, 2]) == pytest.approx(1.0)
    (mount,) = found["/tf_static"][0][1].transforms
    assert (mount.header.frame_id, mount.child_frame_id) == ("base_link", "laser")


@pytest.mark.parametrize("upside_down", [False, True])
def test_poses_are_shifted_and_points_deskewed_as_in_the_map(tmp_path: Path, upside_down: bool) -> None:
    log = replace(swept(8), mount=(0.2, -0.1, 0.3), upside_down=upside_down)
    config = MappingConfig(resolution=0.1, time_offset=0.05)
    grid = OccupancyGrid(geometry_for(log, config))
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, GrowingMap(grid, config), "true")
    found = read(path)
    for index in (0, 3):
        placed = placed_scan(log, config, "true", index)
        position = found["/pose"][index][1].pose.position
        assert (position.x, position.y) == pytest.approx(tuple(placed.base_pose[:2]))
        points = found["/points"][index][1].data.view(np.float32).reshape(-1, 3)
        sign = -1.0 if upside_down else 1.0
        ends = np.stack([np.cos(placed.scan.angles), sign * np.sin(placed.scan.angles)], axis=1)
        np.testing.assert_allclose(points[:, :2], placed.scan.ranges[:, None] * ends, atol=1e-5)


def test_an_exported_log_is_read_as_the_same_log(tmp_path: Path, log: ScanLog) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, None, "true")
    again = open_log(path)
    np.testing.assert_array_equal(again.ranges, np.where(log.ranges <= 0, np.nan, log.ranges))
    np.testing.assert_array_equal(again.stamps_ns, log.stamps_ns)
    assert again.upside_down
    np.testing.assert_allclose(again.mount, log.mount, atol=1e-9)
    assert (again.angle_min, again.angle_increment) == pytest.approx((log.angle_min, log.angle_increment), rel=1e-6)
    poses = log.trajectory("true").poses
    np.testing.assert_allclose(again.trajectory("tf/map").poses[:, :2], poses[:, :2], atol=1e-9)
    np.testing.assert_allclose(np.cos(again.trajectory("tf/map").poses[:, 2] - poses[:, 2]), 1.0, atol=1e-9)
    assert again.notes == ()


def test_the_exported_map_grows_with_the_scans(tmp_path: Path, log: ScanLog) -> None:
    _, growing = map_of(log)
    part = replace(growing, n_scans=100)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, part, "true")
    maps = read(path)["/map"]
    assert len(maps) == MOST_MAPS
    stamps = log.stamps_ns.tolist()
    known = []
    for at, message in maps:
        # Independently of the steps: the map of that many scans, made at once.
        grid = growing.grid.emptied()
        integrate_log(grid, log, growing.config, "true", stop=stamps.index(at) + 1)
        np.testing.assert_array_equal(message.data.reshape(grid.geometry.shape), occupancy_values(grid))
        known.append(int(np.count_nonzero(message.data >= 0)))
    assert (maps[0][0], maps[-1][0]) == (stamps[0], stamps[99])
    assert known == sorted(known)
    assert known[0] < known[len(known) // 2] < known[-1]


@pytest.mark.parametrize("model", BY_NAME["model"].choices)
def test_the_last_map_is_the_one_made_at_once(office_log: ScanLog, model: str) -> None:
    config = MappingConfig(model=model, resolution=0.2, range_max=6.0)
    prior = OccupancyGrid(geometry_for(office_log, config), 0.1)
    prior.log_odds[:40], prior.observed[:40] = -0.7, True
    grid = prior.as_prior(0.1)
    integrate_log(grid, office_log, config, stop=60)
    *_, (last, values) = GrowingMap(grid, config, 60).maps(office_log)
    assert last == 59
    np.testing.assert_array_equal(values, occupancy_values(grid))


def test_without_a_scan_the_map_is_the_prior(tmp_path: Path, log: ScanLog) -> None:
    _, growing = map_of(log)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, replace(growing, n_scans=0))
    ((at, message),) = read(path)["/map"]
    assert at == log.stamps_ns[0]
    assert set(message.data.tolist()) == {-1}


@given(st.integers(0, 500_000), st.integers(1, 1 << 28))
def test_maps_are_bounded_in_number_and_size(n_scans: int, n_cells: int) -> None:
    scans = scans_with_a_map(n_scans, n_cells)
    assert len(scans) <= MOST_MAPS
    assert len(scans) <= 2 or len(scans) * n_cells <= MOST_CELLS
    assert scans == sorted(set(scans))
    if n_scans:
        assert (scans[0], scans[-1]) == (0, n_scans - 1)
        assert len(scans) >= min(n_scans, 2)


def test_maps_are_made_and_written_one_by_one(log: ScanLog) -> None:
    config = MappingConfig(resolution=0.015)
    grid = OccupancyGrid(geometry_for(log, config))
    growing, cells = GrowingMap(grid, config), grid.log_odds.size

    class Counted(io.BytesIO):
        """A file that keeps nothing."""

        written = 0

        def write(self, data: Any) -> int:
            self.written += len(data)
            return len(data)

        def tell(self) -> int:
            return self.written

    coarse = MappingConfig(resolution=0.2)
    coarse_map = GrowingMap(OccupancyGrid(geometry_for(log, coarse)), coarse)
    write_mcap(Counted(), log, coarse_map)  # kernels are compiled, or loaded from the cache
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        write_mcap(Counted(), log, growing)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # A grid of 5 bytes a cell, its values, the message, its copies in the chunk, and the compressed chunk.
    assert peak - before < 16 * cells + 32e6
    assert MOST_MAPS * cells > 16 * cells + 32e6, "all maps together would not have fitted"


def test_foxgloves_own_decoder_reads_it_by_the_definitions_in_the_file(tmp_path: Path, log: ScanLog) -> None:
    grid, growing = map_of(log)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, growing, "true")
    said: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        for _, channel, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            said.setdefault(channel.topic, []).append(message)
    occupancy = said["/map"][-1]
    assert (occupancy.info.width, occupancy.info.height) == grid.geometry.shape[::-1]
    assert list(occupancy.data) == occupancy_values(grid).ravel().tolist()
    poses = log.trajectory("true").poses
    assert len(said["/pose"]) == len(said["/scan"]) == len(said["/tf"]) == log.n_scans
    for pose, laser_scan, tf, (x, y, yaw), ranges in zip(
        said["/pose"], said["/scan"], said["/tf"], poses, log.ranges, strict=True
    ):
        assert (pose.header.frame_id, laser_scan.header.frame_id) == ("map", "laser")
        position, turn = pose.pose.position, pose.pose.orientation
        assert (position.x, position.y, position.z) == (x, y, 0.0)
        assert (turn.z, turn.w) == pytest.approx((math.sin(yaw / 2.0), math.cos(yaw / 2.0)))
        np.testing.assert_array_equal(np.array(laser_scan.ranges, dtype=np.float32), ranges)
        assert (tf.transforms[0].transform.translation.x, tf.transforms[0].child_frame_id) == (x, "base_link")


def test_another_reader_finds_where_the_beams_ended(tmp_path: Path, log: ScanLog) -> None:
    ranges = log.ranges.copy()
    ranges[3, :5] = [np.inf, -np.inf, np.nan, 0.0, 2.0 * log.range_max]
    holed = replace(log, ranges=ranges)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, holed)
    clouds, scans = read(path)["/points"], read(path)["/scan"]
    for index in (0, 3, log.n_scans - 1):
        cloud, scan = clouds[index][1], scans[index][1]
        assert (cloud.header.frame_id, cloud.header.stamp) == ("laser", scan.header.stamp)
        assert [(one.name, one.datatype, one.count) for one in cloud.fields] == [(axis, 7, 1) for axis in "xyz"]
        assert (cloud.height, cloud.is_dense, cloud.is_bigendian) == (1, True, False)
        assert cloud.row_step == cloud.point_step * cloud.width == len(cloud.data)
        rows = cloud.data.reshape(cloud.width, cloud.point_step)
        points = np.hstack([rows[:, one.offset : one.offset + 4].copy().view("<f4") for one in cloud.fields])
        turns = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        ends = [
            (r * math.cos(turn), r * math.sin(turn), 0.0)
            for r, turn in zip(scan.ranges.tolist(), turns.tolist(), strict=True)
            if r > 0.0 and scan.range_min <= r <= scan.range_max
        ]
        np.testing.assert_allclose(points, ends, atol=1e-4)
    assert clouds[3][1].width == sum(scans[3][1].ranges <= scans[3][1].range_max) - 2  # without −inf and 0


def test_the_definitions_in_the_file_are_those_of_ros(log: ScanLog) -> None:
    lasers, sonars = io.BytesIO(), io.BytesIO()
    write_mcap(lasers, log, map_of(log)[1])
    write_mcap(sonars, sonars_of(log))
    theirs = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    seen = set()
    for file in (lasers, sonars):
        file.seek(0)
        summary = make_reader(file).get_summary()
        assert summary is not None
        for schema in summary.schemas.values():
            for name, ours in get_types_from_msg(schema.data.decode(), schema.name).items():
                seen.add(name)
                assert ours[1] == theirs[name][1], name  # the fields, in their order
                assert set(ours[0]) <= set(theirs[name][0]), name  # the constants
    assert {"sensor_msgs/msg/PointField", "sensor_msgs/msg/Range", "tf2_msgs/msg/TFMessage"} < seen


def test_map_and_mount_are_latched_for_late_subscribers(tmp_path: Path, log: ScanLog) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, log, map_of(log)[1])
    with AnyReader([path]) as reader:
        offered = {one.topic: one.ext.offered_qos_profiles for one in reader.connections}  # type: ignore[union-attr]
    assert all(len(one) == 1 for one in offered.values())
    latched = {topic for topic, (one,) in offered.items() if one.durability == QosDurability.TRANSIENT_LOCAL}
    assert latched == {"/map", "/tf_static"}
    assert {one.reliability for (one,) in offered.values()} == {QosReliability.RELIABLE}


def test_sonars_are_range_messages_in_frames_of_their_own(tmp_path: Path, log: ScanLog) -> None:
    sonars = sonars_of(log)
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        write_mcap(file, sonars)
    found = read(path)
    assert {"/sonar_0", "/sonar_1", "/sonar_2"} < set(found)
    assert "/scan" not in found
    reading = found["/sonar_2"][5][1]
    assert (reading.header.frame_id, reading.range) == ("sonar_2", sonars.ranges[5, 2])
    assert reading.field_of_view == pytest.approx(0.3)
    again = open_log(path, topic="/sonar_2")
    x, y, yaw = sonars.mount
    np.testing.assert_allclose(again.mount, (x, y, yaw + 1.4), atol=1e-9)


def test_the_mcap_library_finds_a_summary_and_good_checksums(log: ScanLog) -> None:
    file = io.BytesIO()
    write_mcap(file, log, map_of(log)[1])
    reader = make_reader(io.BytesIO(file.getvalue()), validate_crcs=True)
    summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 1 + MOST_MAPS + 4 * log.n_scans == sum(1 for _ in reader.iter_messages())
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}


@given(st.lists(st.integers(-(2**63), 2**63 - 1), max_size=20))
def test_times_that_every_player_takes(stamps: list[int]) -> None:
    given_ns = np.array(stamps, dtype=np.int64)
    times = export_stamps(given_ns)
    assert len(times) == len(stamps)
    assert (np.diff(times) >= 0).all()
    assert ((times >= 0) & (times <= LAST_STAMP_NS)).all()


def test_good_times_stay_and_a_log_without_times_gets_some() -> None:
    good = np.array([5, 7, 7, 2_000_000_000], dtype=np.int64)
    np.testing.assert_array_equal(export_stamps(good), good)
    np.testing.assert_array_equal(export_stamps(np.zeros(3, dtype=np.int64)), [0, 100_000_000, 200_000_000])
    np.testing.assert_array_equal(export_stamps(np.array([-5, 3, 1], dtype=np.int64)), [0, 8, 8])


def test_a_trajectory_that_the_log_lacks_is_refused(log: ScanLog) -> None:
    for take in (lambda: tum_text(log, "gps"), lambda: write_mcap(io.BytesIO(), log, None, "gps")):
        with pytest.raises(ConfigError, match="no trajectory 'gps'"):
            take()
