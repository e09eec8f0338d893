"""Real logs against figures computed from them independently."""

from __future__ import annotations

import gzip

import numpy as np
import pytest

from mapper.core.se2 import wrap_angle
from mapper.io.logs import is_log, open_log
from mapper.io.logs.summary import summarise


@pytest.mark.parametrize(
    ("name", "n_scans", "n_beams", "trajectories"),
    [
        ("intel", 910, 180, ["scan", "wheel"]),
        ("intel-corrected", 910, 180, ["scan", "wheel"]),
        ("intel_merged", 3461, 180, ["scan", "wheel"]),
        ("intel-robotlaser", 2672, 180, ["scan"]),
        ("aces", 440, 180, ["scan", "wheel"]),
        ("fhw-corrected", 488, 180, ["scan", "wheel"]),
        ("loop5", 551, 181, ["scan"]),
    ],
)
def test_scans_beams_and_trajectories(data_file, name, n_scans, n_beams, trajectories):
    log = open_log(data_file(f"carmen/{name}.log.gz"))
    assert (log.n_scans, log.n_beams, list(log.trajectories)) == (n_scans, n_beams, trajectories)


def test_intel_against_a_plain_reading_of_its_columns(data_file):
    path = data_file("carmen/intel.log.gz")
    text = gzip.decompress(path.read_bytes())
    rows = [line.split() for line in text.splitlines() if line.startswith(b"FLASER")]
    columns = np.array([[float(field) for field in row[2:189]] for row in rows])
    log = open_log(path)
    expected = np.where(columns[:, :180] >= 80.0, np.inf, columns[:, :180]).astype(np.float32)
    np.testing.assert_array_equal(log.ranges, expected)
    np.testing.assert_allclose(log.trajectory("scan").poses[:, :2], columns[:, 180:182], atol=1e-12)
    np.testing.assert_allclose(log.stamps_ns / 1e9, columns[:, 186], atol=1e-5)
    counted = summarise(log).readings
    assert (counted.no_return, counted.invalid) == (4172, 0)
    assert counted.measured == 910 * 180 - 4172


@pytest.mark.parametrize("name", ["intel", "aces", "fhw"])
def test_wheel_odometry_of_a_raw_log_is_the_pose_of_its_scan_lines(data_file, name):
    log = open_log(data_file(f"carmen/{name}.log.gz"))
    np.testing.assert_allclose(log.trajectory("wheel").poses[:, :2], log.trajectory("scan").poses[:, :2], atol=1e-5)


@pytest.mark.parametrize("name", ["intel", "aces", "fhw"])
def test_wheel_odometry_of_a_corrected_log_is_that_of_the_raw_log(data_file, name):
    raw = open_log(data_file(f"carmen/{name}.log.gz")).trajectory("scan").poses
    wheel = open_log(data_file(f"carmen/{name}-corrected.log.gz")).trajectory("wheel").poses
    np.testing.assert_allclose(wheel[:, :2], raw[:, :2], atol=1e-4)
    assert np.abs(wrap_angle(wheel[:, 2] - raw[:, 2])).max() < 1e-4


def test_the_corrected_poses_are_those_of_the_reference_trajectory(data_file):
    """The reference has one corrected pose for each odometry message; each scan's pose must be one of them."""
    log = open_log(data_file("carmen/intel-corrected.log.gz"))
    reference = np.loadtxt(data_file("carmen/intel.ref.tum"))
    poses = log.trajectory("scan").poses
    distance = np.array([np.hypot(*(reference[:, 1:3] - pose[:2]).T).min() for pose in poses])
    assert np.median(distance) < 0.01
    assert distance.max() < 0.2


def test_formats_are_distinguished_from_similar_ones(data_dir):
    """Among all the data only logs and recordings are: not maps, trajectories, pictures or prose."""
    files = [path for path in data_dir.rglob("*") if path.is_file()]
    logs = {str(path.relative_to(data_dir)) for path in files if is_log(path)}
    assert logs == {
        str(path.relative_to(data_dir))
        for path in files
        if (path.parent.name == "carmen" and ".log" in path.name)
        or path.parent.name in ("bags", "breezyslam")
        or path.name in ("measurement.txt", "robotdata1.log.gz")
    }
