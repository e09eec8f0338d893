"""Recordings of 3D lidars and depth cameras, of which scans are made, as public reports describe them.

A test names the reports. Each robot drives in a room whose walls are known.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from mapper.diagnosis import diagnose
from mapper.io.logs import open_log
from tests.mapper.io.logs.recorded import SECOND, Said, cloud, scan, transform, written
from tests.reports.test_transforms import LASER, STEP, T0, N, by_tf, drive, static, true


def clouds(height: float = 0.0) -> list[Said]:
    """Clouds of a lidar at the robot's base, whose points are ``height`` above it."""
    ring = [(2.0 * math.cos(a), 2.0 * math.sin(a), height) for a in np.linspace(-3.0, 3.0, 60)]
    return [cloud(T0 + i * STEP + SECOND // 50, ring) for i in range(N)]


def test_clouds_outside_of_the_heights_that_count_are_told_so(tmp_path: Path) -> None:
    """pointcloud_to_laserscan#43, pointcloud_to_laserscan#84, go2_ros2_sdk#167: the map was empty without a word.

    The doctor ended with "Max range must be a finite number": what did not return counted as measured.
    """
    poses = [said for said in drive(by_tf()) if said.topic != "/scan"]
    for height, words in ((-0.4, "they are at -0.4 to -0.4 m"), (0.5, "")):
        mount = static("base_link", "velodyne", (0.0, 0.0, 0.0))
        log = open_log(written(tmp_path / str(height), [mount, *poses, *clouds(height)], "db3"))
        noted = [note for note in log.notes if "No point of the clouds on /points is between 0 and 1000 m" in note]
        assert len(noted) == bool(words)
        assert not words or words in noted[0]
        assert not any("Max range" in finding.sentence for finding in diagnose(log).findings)


def test_a_sensor_without_a_greatest_range_measures_nothing_infinite(tmp_path: Path) -> None:
    """ros_gz#115: inf where nothing is in reach; range_max inf as of simulated lidars."""
    nothing = np.full(30, math.inf)
    said = [scan(T0 + i * STEP, nothing, limits=(0.1, math.inf)) for i in range(N)]
    log = open_log(written(tmp_path, [LASER, *(one for one in drive(by_tf()) if one.topic != "/scan"), *said], "db3"))
    assert any(note.startswith("All 600 readings are no return") for note in log.notes)
    assert [finding.check for finding in diagnose(log).findings] == ["readings.few"]


TURN_S = 0.19  #: of a lidar
POINTS = 360


def in_a_room(place: tuple[float, float, float], bearing: float) -> float:
    """The distance to the walls of a square room of 8 × 8 m around (0, 2)."""
    x, y, yaw = place
    c, s = math.cos(yaw + bearing), math.sin(yaw + bearing)
    along = ((4.0 - x) / c if c > 0.0 else (-4.0 - x) / c) if c else math.inf
    across = ((6.0 - y) / s if s > 0.0 else (-2.0 - y) / s) if s else math.inf
    return min(along, across)


def turning(field: str, code: str, unit: float, stamped: float, *, clockwise: bool, stray: bool) -> list[Said]:
    """A lidar that turns once while the robot drives on, and states when it measured each point.

    ``stamped`` is when in the turn a cloud has its stamp, 0 … 1. With ``stray`` some points have impossible times.
    """
    bearings = np.linspace(-math.pi, math.pi, POINTS, endpoint=False)
    share = np.arange(POINTS) / POINTS
    if clockwise:
        share = share[::-1]
    said: list[Said] = [static("base_link", "velodyne", (0.0, 0.0, 0.0))]
    for i in range(N * 10 + 1):
        at = T0 + i * STEP // 10
        said.append(transform(at, "odom", "base_link", *true(6.0 * i / 10)))
    for i in range(N - 1):
        places = [true(6.0 * (i + share[k] * TURN_S * SECOND / STEP)) for k in range(POINTS)]
        ranges = np.array([in_a_room(place, b) for place, b in zip(places, bearings, strict=True)])
        points = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings), np.zeros(POINTS)], axis=-1)
        times = (share - stamped) * TURN_S / unit
        if stray and i % 3 == 0:
            times[::50] = 3.6 / unit
        layout = (("x", "f4"), ("y", "f4"), ("z", "f4"), (field, code))
        stamp = T0 + i * STEP + round(stamped * TURN_S * SECOND)
        said.append(cloud(stamp, points, layout=layout, others={field: times}))
    return sorted(said, key=lambda one: one.stamp_ns)


TIMED: dict[str, list[Said]] = {
    "ouster-ros#350: ns after the stamp": turning("t", "u4", 1e-9, 0.0, clockwise=False, stray=False),
    "M2DGR#87, Point-LIO#15: s before the stamp": turning("time", "f4", 1.0, 1.0, clockwise=False, stray=False),
    "a lidar that turns clockwise": turning("time", "f4", 1.0, 0.0, clockwise=True, stray=False),
    "vbr-devkit#7: some impossible times": turning("t", "u4", 1e-9, 0.0, clockwise=False, stray=True),
}


@pytest.mark.parametrize("name", TIMED)
def test_scans_of_clouds_have_the_times_of_their_points(tmp_path: Path, name: str) -> None:
    """They were taken as measured at once, or deskewed with a finding that the driver states a wrong time_increment."""
    log = open_log(written(tmp_path, TIMED[name], "db3"))
    clockwise = "clockwise" in name
    increment = -log.time_increment if clockwise else log.time_increment
    assert increment == pytest.approx(TURN_S / POINTS, rel=0.05)
    assert log.can_deskew()
    begins = log.stamps_ns[0] - T0
    assert begins / SECOND == pytest.approx(TURN_S if clockwise else 0.0, abs=0.005)
    assert not [note for note in log.notes if "fit together" in note]
    assert not [finding for finding in diagnose(log).findings if finding.check == "timing.increment"]


def test_times_that_begin_elsewhere_than_the_cut_are_not_used(tmp_path: Path) -> None:
    """A scan has one time for its first beam, and one from each beam to the next."""
    said = turning("time", "f4", 1.0, 0.0, clockwise=False, stray=False)
    for one in said:
        if one.topic == "/points":
            points = np.frombuffer(one.fields["data"].tobytes(), dtype="<f4").reshape(-1, 4).copy()
            points[:, 3] = np.roll(points[:, 3], POINTS // 3)
            one.fields["data"] = np.frombuffer(points.tobytes(), dtype=np.uint8)
    log = open_log(written(tmp_path, said, "db3"))
    assert log.time_increment == 0.0
