"""Recordings with camera images: the topics of the map are read, and the images are skipped."""

from __future__ import annotations

import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import mcap.reader
import numpy as np
import pytest

from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog
from tests.mapper.io.logs import camera_recordings, recorded
from tests.mapper.io.logs.camera_recordings import CameraRun
from tests.mapper.io.logs.recorded import SECOND, Said, scan, text

IO = Path("/proc/self/io")
RUN = CameraRun(600)  # with 60 images of 0.9 MB
T0 = camera_recordings.T0


def bytes_read() -> int:
    """Bytes that this process has read so far, of all files."""
    return int(IO.read_text().split()[1])


@pytest.mark.skipif(not IO.is_file(), reason="what a process reads is counted there")
@pytest.mark.parametrize("kind", ["mcap", "bag", "db3"])
def test_images_are_neither_read_nor_held(tmp_path, kind):
    path = camera_recordings.write(tmp_path / "run", kind, RUN)
    assert path.stat().st_size > 58_000_000
    before = bytes_read()
    log = open_log(path)
    assert bytes_read() - before < 2 * RUN.scan_bytes
    tracemalloc.start()
    try:
        open_log(path)
        assert tracemalloc.get_traced_memory()[1] < 3 * RUN.scan_bytes
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(log.ranges, camera_recordings.ranges(RUN))
    robot = log.trajectory("tf/odom").poses
    laser = camera_recordings.poses(RUN)
    np.testing.assert_allclose(log.sensor_poses("tf/odom")[:, :2], laser[:, :2], atol=1e-9)
    assert robot.shape == laser.shape
    assert {topic.name: topic.count for topic in log.topics} == {"/scan": 600, "/tf": 601, "/camera/image_raw": 60}
    assert log.notes == ()


def beside(n: int = 12, size: int = 200_000) -> list[Said]:
    """Scans with the same number of long texts, of letters that do not compress well, after each."""
    letters = np.random.default_rng(1).integers(32, 127, n * size, dtype=np.uint8).tobytes().decode()
    said = []
    for i in range(n):
        at = T0 + i * SECOND
        said += [scan(at, [1.0 + i, 2.0]), *(text(at, letters[i * size : (i + 1) * size]) for _ in range(3))]
    return said


def the_same(a: ScanLog, b: ScanLog) -> bool:
    topics = [{(one.name, one.count) for one in log.topics} for log in (a, b)]
    return np.array_equal(a.ranges, b.ranges) and np.array_equal(a.stamps_ns, b.stamps_ns) and topics[0] == topics[1]


@pytest.mark.skipif(not IO.is_file(), reason="what a process reads is counted there")
@pytest.mark.parametrize("kind", ["mcap-zstd", "mcap-lz4", "bag-lz4"])
def test_compressed_chunks_without_a_scan_are_passed_over(tmp_path, kind):
    """Each second and third text is in a chunk of its own, and is counted by the index of the chunk."""
    path, (container, compression) = tmp_path / "run", kind.split("-")
    if container == "mcap":
        path.write_bytes(recorded.mcap_bytes(beside(), compression, chunk_size=50_000))
    else:
        recorded.write_bag(path, beside(4, 1_100_000), compression)
    n = 12 if container == "mcap" else 4
    before = bytes_read()
    log = open_log(path)
    assert bytes_read() - before < 0.6 * path.stat().st_size
    assert {topic.name: topic.count for topic in log.topics} == {"/scan": n, "/chatter": 3 * n}
    assert log.ranges[:, 0].tolist() == [1.0 + i for i in range(n)]


def test_an_mcap_without_its_end_is_read_the_same(tmp_path):
    path = tmp_path / "run.mcap"
    data = recorded.mcap_bytes(beside(), "zstd", chunk_size=50_000)
    path.write_bytes(data)
    whole = open_log(path)
    with path.open("rb") as file:
        summary = mcap.reader.make_reader(file).get_summary()
    assert summary is not None
    last = summary.chunk_indexes[-1]
    path.write_bytes(data[: last.chunk_start_offset + last.chunk_length])
    assert the_same(whole, open_log(path))


def test_an_uncompressed_chunk_larger_than_the_record_limit_is_read(tmp_path):
    """Of a chunk of any size only the scans are held."""
    path = tmp_path / "run.mcap"
    path.write_bytes(recorded.mcap_bytes(beside(), "none", chunk_size=1 << 30))
    assert the_same(open_log(path), open_log(path, limits=replace(DEFAULT_LIMITS, max_chunk_bytes=100_000)))


def test_a_plain_chunk_of_scans_is_left_out_where_its_checksum_is_wrong(tmp_path):
    path = tmp_path / "run.mcap"
    said = [scan(T0 + i, np.full(1000, 1.0 + i)) for i in range(200)]
    data = bytearray(recorded.mcap_bytes(said, "none", chunk_size=500_000))
    at = data.index(struct.pack("<f", 3.0) * 1000)
    path.write_bytes(data)
    assert open_log(path).n_scans == 200
    data[at] ^= 4
    path.write_bytes(data)
    log = open_log(path)
    assert 0 < log.n_scans < 200
    assert any("has not the checksum that it states, and is left out" in note for note in log.notes)
