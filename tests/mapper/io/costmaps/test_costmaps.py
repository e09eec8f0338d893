"""Costmap messages: a real recording against an independent reader, and written files read by two."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from mapper.core.errors import MapperError, ReadError
from mapper.costmap.files import save_costmap_mcap
from mapper.grid import GridGeometry
from mapper.io.costmaps import costmap_message, occupancy_of_costs, open_costmaps
from mapper.io.export import ros2
from mapper.io.logs.ros.message_fields import BadMessageError

RECORDING = "bags/cm_moving_obstacle_0.mcap"


def test_every_cell_of_a_real_recording(data_file: Callable[[str], Path]) -> None:
    """231 costmaps of a Nav2 against mcap-ros2-support, which reads by the definitions in the file."""
    path = data_file(RECORDING)
    streams = open_costmaps(path)
    assert list(streams) == ["/local_costmap/costmap"]
    stream = streams["/local_costmap/costmap"]
    assert (len(stream), stream.bad) == (231, 0)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = reader.iter_decoded_messages(topics=["/local_costmap/costmap"])
        for ours, (_, _, raw, theirs) in zip(stream, messages, strict=True):
            meta = theirs.metadata
            assert (ours.geometry.cols, ours.geometry.rows) == (meta.size_x, meta.size_y)
            assert ours.costs.ravel().tobytes() == bytes(theirs.data)
            assert ours.geometry.origin[:2] == (meta.origin.position.x, meta.origin.position.y)
            assert ours.geometry.resolution == pytest.approx(meta.resolution, rel=1e-6)
            assert ours.stamp_ns == theirs.header.stamp.sec * 10**9 + theirs.header.stamp.nanosec
            assert (ours.frame, ours.layer, ours.received_ns) == (theirs.header.frame_id, meta.layer, raw.log_time)


def test_written_costmaps_are_read_by_others(tmp_path: Path) -> None:
    costs = np.random.default_rng(1).integers(0, 256, (30, 41)).astype(np.uint8)
    geometry = GridGeometry(0.05, 30, 41, (-1.5, 2.25, 0.5))
    path = tmp_path / "out" / "costs.mcap"
    save_costmap_mcap(costs, geometry, path, "odom", 1_500_000_001)
    with AnyReader([path]) as reader:
        found: dict[str, Any] = {c.topic: reader.deserialize(data, c.msgtype) for c, _, data in reader.messages()}
    raw, grid = found["/costmap_raw"], found["/costmap"]
    assert (raw.metadata.size_x, raw.metadata.size_y, raw.header.frame_id) == (41, 30, "odom")
    assert (raw.header.stamp.sec, raw.header.stamp.nanosec) == (1, 500_000_001)
    np.testing.assert_array_equal(raw.data.reshape(30, 41), costs)
    assert raw.metadata.origin.orientation.w == pytest.approx(np.cos(0.25))
    np.testing.assert_array_equal(grid.data.reshape(30, 41), occupancy_of_costs(costs))
    again = open_costmaps(path)["/costmap_raw"][0]
    np.testing.assert_array_equal(again.costs, costs)
    assert again.geometry.origin == pytest.approx(geometry.origin)
    assert (again.geometry.resolution, again.layer) == (0.05, "master")


def test_costs_of_an_occupancy_grid() -> None:
    """By hand, from costmap_2d_publisher.cpp: 1 + (97 · (cost − 1)) / 251 in whole numbers between 1 and 252."""
    costs = np.array([0, 1, 2, 3, 128, 251, 252, 253, 254, 255], dtype=np.uint8)
    assert occupancy_of_costs(costs).tolist() == [0, 1, 1, 1, 50, 97, 98, 99, 100, -1]


def test_files_without_costmaps_are_refused(tmp_path: Path, data_file: Callable[[str], Path]) -> None:
    with pytest.raises(ReadError, match="holds no costmaps"):
        open_costmaps(data_file("bags/b0-tiny.bag"))
    with pytest.raises(MapperError):
        open_costmaps(tmp_path / "none.mcap")


@pytest.mark.parametrize(
    ("field", "said"),
    [("size", "cells, and it has 12"), ("resolution", "resolution must be a positive"), ("turn", "is not a rotation")],
)
def test_a_message_that_says_something_impossible(tmp_path: Path, field: str, said: str) -> None:
    data = bytearray(ros2.costmap(0, "map", "master", 0.1, (0.0, 0.0, 0.0), np.zeros((3, 4), np.uint8)))
    place = data.index(struct.pack("<f2I", 0.1, 4, 3))
    if field == "size":
        struct.pack_into("<I", data, place + 4, 1 << 30)
    elif field == "resolution":
        struct.pack_into("<f", data, place, -1.0)
    else:
        end = len(data) - 12 - 4
        data[end - 32 : end] = bytes(32)
    with pytest.raises(BadMessageError, match=said):
        costmap_message(bytes(data), cdr=True)


def test_every_prefix_of_a_message_is_refused_or_read() -> None:
    data = ros2.costmap(0, "map", "master", 0.1, (0.0, 0.0, 0.0), np.zeros((3, 4), np.uint8))
    for n in range(len(data)):
        with pytest.raises(BadMessageError):
            costmap_message(data[:n], cdr=True)
