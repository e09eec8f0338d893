"""The recording has what was appended, does not change arrays that it returned, and is thinned evenly."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.sensors.scan import LaserScan
from mapper.simulation import WORLDS, Recording, SensorConfig, Simulation

SENSOR = SensorConfig(n_beams=30, scan_rate=10.0)


def walk(seconds: float, sensor: SensorConfig = SENSOR) -> list[tuple[LaserScan, tuple[float, float, float]]]:
    return Simulation(WORLDS["room"], sensor, 1).advance(seconds)


def test_a_recording_equals_what_was_appended():
    recording = Recording(SENSOR, mount=(0.1, 0.0, 0.2))
    taken = walk(40.0)
    for scan, pose in taken:
        recording.append(scan, pose)
    log = recording.as_log()
    assert len(recording) == log.n_scans == len(taken) == 400
    np.testing.assert_array_equal(log.ranges, [scan.ranges for scan, _ in taken])
    np.testing.assert_array_equal(log.trajectory("true").poses, [pose for _, pose in taken])
    np.testing.assert_array_equal(log.stamps_ns, [scan.stamp_ns for scan, _ in taken])
    np.testing.assert_array_equal(log.angles, taken[0][0].angles)
    assert log.range_max == SENSOR.range_max
    assert log.mount == (0.1, 0.0, 0.2)
    assert recording.generation == 0


def test_a_log_is_a_view_and_later_scans_do_not_change_it():
    recording = Recording(SENSOR)
    taken = walk(60.0)
    for scan, pose in taken[:100]:
        recording.append(scan, pose)
    early = recording.as_log()
    assert np.shares_memory(early.ranges, recording.as_log().ranges)
    kept = early.ranges.copy()
    for scan, pose in taken[100:]:
        recording.append(scan, pose)
    np.testing.assert_array_equal(early.ranges, kept)
    np.testing.assert_array_equal(recording.as_log().ranges[:100], kept)


def test_a_full_recording_is_thinned_evenly():
    capacity = 1000
    recording = Recording(SENSOR, capacity)
    taken = walk(300.0)
    early = None
    for i, (scan, pose) in enumerate(taken):
        recording.append(scan, pose)
        assert len(recording) <= capacity
        if i == 999:
            early = recording.as_log()
    assert early is not None
    np.testing.assert_array_equal(early.ranges, [scan.ranges for scan, _ in taken[:1000]])  # not written to
    log = recording.as_log()
    assert recording.generation >= 3
    assert capacity // 4 < log.n_scans <= capacity
    assert np.all(np.diff(log.stamps_ns) > 0)
    by_stamp = {scan.stamp_ns: (scan, pose) for scan, pose in taken}
    for i in range(log.n_scans):
        scan, pose = by_stamp[int(log.stamps_ns[i])]
        np.testing.assert_array_equal(log.ranges[i], scan.ranges)
        np.testing.assert_array_equal(log.trajectory().poses[i], pose)
    # Wherever the robot was, a scan from within the same square of half a metre is left; the newest one always is.
    squares = {tuple(np.floor(np.array(pose[:2]) / 0.5).astype(int)) for _, pose in taken}
    left = {tuple(row) for row in np.floor(log.trajectory().poses[:, :2] / 0.5).astype(int)}
    assert left == squares
    assert log.stamps_ns[-1] == taken[-1][0].stamp_ns


def test_more_places_than_room_are_thinned_evenly_and_places_far_apart_to_the_newest():
    scan = walk(0.1)[0][0]
    recording = Recording(SENSOR, capacity=64)
    for i in range(65):
        recording.append(scan, (0.6 * i, 0.0, 0.0))
    x = recording.as_log().trajectory().poses[:, 0]
    assert 16 < len(x) <= 33
    assert np.diff(x, prepend=0.0).max() <= 4.0  # no gap longer than two of the larger squares
    recording = Recording(SENSOR, capacity=10)
    for i in range(25):
        recording.append(scan, (100.0 * i, 0.0, 0.0))
    x = recording.as_log().trajectory().poses[:, 0] / 100.0
    np.testing.assert_array_equal(x, np.arange(25 - len(x), 25))


def test_which_sensors_share_a_recording():
    recording = Recording(SENSOR)
    assert recording.fits(SENSOR.with_values({"range_noise": 0.1, "scan_rate": 5.0}))
    for name, value in {"n_beams": 60, "field_of_view": 3.0, "range_max": 4.0}.items():
        other = SENSOR.with_values({name: value})
        assert not recording.fits(other)
        with pytest.raises(ConfigError, match="A scan of"):
            recording.append(walk(0.1, sensor=other)[0][0], (0.0, 0.0, 0.0))
    assert len(recording) == 0


def test_clear_forgets_and_impossible_arguments_are_refused():
    recording = Recording(SENSOR)
    scan, pose = walk(0.1)[0]
    recording.append(scan, pose)
    recording.clear()
    assert len(recording) == recording.as_log().n_scans == 0
    assert recording.generation == 1
    with pytest.raises(ConfigError, match="pose"):
        recording.append(scan, (0.0, np.nan, 0.0))
    with pytest.raises(ConfigError, match="pose"):
        recording.append(scan, (0.0, 1.0))
    with pytest.raises(ConfigError, match="at least 2"):
        Recording(SENSOR, capacity=1)
