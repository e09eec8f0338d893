"""CMU's ``L`` and ``O`` lines, and the result of reading them."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.logs import is_log, open_log
from mapper.sensors.scan import ScanLog

READINGS = ["50", "8183", "0", *["120"] * 177]


def laser(robot=(100, 200, 0), sensor=(125, 200, 0), readings=READINGS, stamp=0.5) -> str:
    return f"L {' '.join(map(str, [*robot, *sensor, *readings]))} {stamp}"


def written(folder: Path, *lines: str) -> ScanLog:
    path = folder / "a.log"
    path.write_text("".join(line + "\n" for line in lines))
    return open_log(path)


def test_centimetres_become_metres_and_the_mount_is_between_the_two_poses(tmp_path):
    log = written(tmp_path, "O 90 200 0 0.0", laser(), "O 110 200 0 1.0", laser((110, 200, 0), (135, 200, 0), stamp=1))
    assert log.format == "CMU"
    np.testing.assert_allclose(log.mount, (0.25, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(log.ranges[0, 3], 1.2, rtol=1e-6)
    assert np.isposinf(log.ranges[:, 1]).all()
    assert np.isnan(log.ranges[:, 2]).all()
    np.testing.assert_allclose(log.trajectory("scan").poses, [[1.0, 2.0, 0.0], [1.1, 2.0, 0.0]])
    np.testing.assert_allclose(log.trajectory("wheel").poses[0], [1.0, 2.0, 0.0])
    assert log.stamps_ns.tolist() == [500_000_000, 1_000_000_000]
    assert (log.angle_min, log.angle_increment) == (-math.pi / 2, math.radians(1.0))


def test_another_place_of_the_laser_in_one_line_is_noted(tmp_path):
    good = [laser((i, 0, 0), (i + 25, 0, 0), stamp=i) for i in range(4)]
    log = written(tmp_path, *good, laser((9, 0, 0), (64, 0, 0), stamp=9))
    np.testing.assert_allclose(log.mount, (0.25, 0.0, 0.0), atol=1e-12)
    assert any(note.startswith("1 L lines state another place") for note in log.notes)


@pytest.mark.parametrize(
    ("bad", "code", "words"),
    [
        ("O 1 2 3", "log.truncated_line", "Line 2: this O line ends early: it has 4 of 5 fields"),
        ("O 1 2 3 4 5", "log.beam_count", "Line 2: an O line has 5 fields, this one has 6"),
        (laser(readings=READINGS[1:]), "log.truncated_line", "Line 2: this L line ends early: it has 187 of 188"),
        (laser(readings=["1", *READINGS]), "log.beam_count", "Line 2: an L line has 188 fields, this one has 189"),
        (laser(readings=["5O", *READINGS[1:]]), "log.not_a_number", "Line 2: '5O' in this L line"),
        (laser(robot=("nan", 0, 0)), "log.pose", "Line 2: the robot’s pose in this L line is not finite"),
        (laser(sensor=(1e9, 0, 0)), "log.pose", "Line 2: the laser’s pose"),
        ("O 1 2 3 1e12", "log.stamp", "Line 2: the time '1e12' of this O line is impossible"),
        ("O 1 2 3 1.6e18", "log.stamp", "impossible. It would be one in nanoseconds: divide the log’s times by"),
        ("X 1 2 3 4", "log.garbage", "Line 2 is not a CMU message"),
    ],
)
def test_a_damaged_line_is_named(tmp_path, bad, code, words):
    with pytest.raises(ReadError, match=words) as caught:
        written(tmp_path, laser(), bad, laser())
    assert caught.value.code == code


def test_odometry_without_scans_is_no_log(tmp_path):
    with pytest.raises(ReadError, match="it has no L line"):
        written(tmp_path, "O 1 2 3 4")


def test_prose_is_no_log(tmp_path):
    path = tmp_path / "instruct.txt"
    path.write_text("Entry Type #1 (odometry):\n\nO x y theta ts\n\nL x y theta xl yl thetal r1 ... r180 ts\n")
    assert not is_log(path)


def test_wean_hall_against_a_plain_reading_of_its_columns(data_file):
    path = data_file("mcl/robotdata1.log.gz")
    rows = [line.split() for line in gzip.decompress(path.read_bytes()).splitlines() if line.startswith(b"L")]
    columns = np.array([[float(field) for field in row[1:]] for row in rows])
    log = open_log(path)
    assert (log.n_scans, log.n_beams, list(log.trajectories)) == (713, 180, ["scan", "wheel"])
    expected = np.where(columns[:, 6:186] >= 8000.0, np.inf, columns[:, 6:186] / 100.0).astype(np.float32)
    np.testing.assert_allclose(log.ranges, expected, rtol=1e-6)
    np.testing.assert_allclose(log.sensor_poses()[:, :2], columns[:, 3:5] / 100.0, atol=1e-6)
    np.testing.assert_allclose(log.stamps_ns / 1e9, columns[:, -1], atol=1e-8)
    np.testing.assert_allclose(log.mount, (0.25, 0.0, 0.0), atol=1e-6)
    # The robot's pose is stated as interpolated from the odometry.
    apart = log.trajectory("wheel").poses[:, :2] - log.trajectory("scan").poses[:, :2]
    assert np.hypot(*apart.T).max() < 0.1
