"""Scans and logs: validation, and the directions of beams."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.core.se2 import compose
from mapper.sensors.beam_fields import beam_fields, uneven_fields
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory


@pytest.fixture
def log() -> ScanLog:
    return ScanLog(
        np.ones((3, 4), dtype=np.float32),
        angle_min=-0.3,
        angle_increment=0.2,
        range_min=0.1,
        range_max=30.0,
        stamps_ns=np.arange(3),
        trajectories={"a": Trajectory(np.zeros((3, 3))), "b": Trajectory(np.ones((3, 3)))},
        mount=(0.5, 0.0, 1.0),
    )


def test_beams_run_counter_clockwise(log: ScanLog) -> None:
    np.testing.assert_allclose(log.angles, [-0.3, -0.1, 0.1, 0.3])
    np.testing.assert_array_equal(log.scan(1).angles, log.angles)
    assert (log.n_scans, log.n_beams) == (3, 4)


def test_an_upside_down_laser_sweeps_the_other_way(log: ScanLog) -> None:
    hanging = replace(log, upside_down=True)
    np.testing.assert_array_equal(hanging.angles, -log.angles)
    np.testing.assert_array_equal(hanging.scan(0).angles, -log.angles)


def test_trajectories_by_name(log: ScanLog) -> None:
    assert log.default_trajectory == "a"
    assert log.trajectory("b").poses[0, 0] == 1.0
    np.testing.assert_array_equal(log.sensor_poses("b")[2], compose((1, 1, 1), (0.5, 0, 1.0)))
    with pytest.raises(ConfigError, match="no trajectory 'c'; it has 'a', 'b'"):
        log.trajectory("c")


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"ranges": np.ones(4)}, "log.shape"),
        ({"stamps_ns": np.arange(2)}, "log.stamps"),
        ({"trajectories": {}}, "log.no_trajectory"),
        ({"trajectories": {"a": Trajectory(np.zeros((2, 3)))}}, "scan.pose_shape"),
        ({"angle_min": np.nan}, "scan.angles"),
        ({"angle_increment": np.inf}, "scan.angles"),
        ({"range_min": -1.0}, "scan.range_limits"),
        ({"range_min": 30.0}, "scan.range_limits"),
        ({"range_max": np.nan}, "scan.range_limits"),
        ({"mount": (0.0, np.nan, 0.0)}, "log.mount"),
        ({"mount": (0.0, 0.0)}, "log.mount"),
    ],
)
def test_a_log_that_cannot_be_is_refused(log: ScanLog, change: dict[str, object], code: str) -> None:
    with pytest.raises(ConfigError) as refused:
        replace(log, **change)  # type: ignore[arg-type]
    assert refused.value.code == code


def test_a_log_above_the_limits_is_refused(log: ScanLog) -> None:
    for limits in (Limits(max_scans=2), Limits(max_beams=3)):
        with pytest.raises(LimitError, match="3 scans × 4 beams"):
            replace(log, limits=limits)


def test_poses_are_checked() -> None:
    poses = np.zeros((3, 3))
    poses[1, 2] = np.nan
    with pytest.raises(ConfigError, match="Pose 1 is not finite"):
        Trajectory(poses)
    with pytest.raises(ConfigError, match="from the origin"):
        Trajectory(np.full((1, 3), 2e6))


def test_an_upside_down_ring_of_sonars_is_mirrored(log: ScanLog) -> None:
    bearings = np.linspace(-0.5, 1.5, log.n_beams) ** 3
    standing = replace(log, bearings=bearings, beam_width=0.1)
    hanging = replace(standing, upside_down=True)
    np.testing.assert_array_equal(standing.angles, bearings)
    np.testing.assert_array_equal(hanging.angles, -bearings)
    np.testing.assert_array_equal(hanging.scan(0).angles, -bearings)
    # Turned over once more, it stands again: each beam has the field that it had, its edges where they were.
    np.testing.assert_allclose(hanging.fields(turned_over=True), standing.fields(), atol=1e-12)
    mirrored = standing.fields()[:, [2, 3, 0, 1]] * [1, -1, 1, -1]
    np.testing.assert_allclose(hanging.fields(), mirrored, atol=1e-8)


def test_one_scan_is_one_row() -> None:
    with pytest.raises(ConfigError, match="one row"):
        LaserScan(np.ones((2, 2)), 0.0, 0.1, 0.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="angle_min"):
        LaserScan(np.ones(2), np.inf, 0.1, 0.0, 1.0)  # type: ignore[arg-type]


def bearing_edges(angle_min: float, increment: float, n: int) -> np.ndarray:
    fields = beam_fields(angle_min, increment, n)
    return np.arctan2(fields[:, [1, 3]], fields[:, [0, 2]])


def test_a_beam_sees_half_an_increment_to_either_side() -> None:
    np.testing.assert_allclose(bearing_edges(-0.1, 0.2, 3), [[-0.2, 0.0], [0.0, 0.2], [0.2, 0.4]], atol=1e-12)
    np.testing.assert_allclose(bearing_edges(0.1, -0.2, 2), [[0.0, 0.2], [-0.2, 0.0]], atol=1e-12)
    fields = beam_fields(-0.1, 0.2, 3)
    np.testing.assert_array_equal(fields[:-1, 2:], fields[1:, :2])


def test_the_fields_of_a_full_turn_are_closed_and_beams_beyond_it_have_none() -> None:
    whole = beam_fields(0.3, 2 * np.pi / 7, 7)
    np.testing.assert_array_equal(whole[-1, 2:], whole[0, :2])
    more = beam_fields(0.3, 2 * np.pi / 7, 9)
    np.testing.assert_array_equal(more[:7], whole)
    np.testing.assert_array_equal(more[7:, :2], more[7:, 2:])


def test_a_coarse_beam_sees_no_more_than_a_quarter_turn() -> None:
    np.testing.assert_allclose(bearing_edges(0.0, 3.0, 1), [[-np.pi / 4, np.pi / 4]])
    np.testing.assert_allclose(bearing_edges(0.5, 0.0, 2), [[0.5, 0.5], [0.5, 0.5]])


def test_coarse_beams_never_see_the_same_place() -> None:
    fields = beam_fields(0.0, 3.0, 4)
    np.testing.assert_allclose(np.arctan2(fields[:2, 1], fields[:2, 0]), [-np.pi / 4, 3.0 - np.pi / 4])
    np.testing.assert_array_equal(fields[2:, :2], fields[2:, 2:])


def test_uneven_beams_divide_the_angle_between_them_in_halves() -> None:
    # In any order; a gap of more than twice ``widest`` has a middle that nobody sees, and of twins the first sees all.
    fields = uneven_fields(np.array([1.0, 0.2, 0.0, 0.2]), widest=0.3)
    edges = np.arctan2(fields[:, [1, 3]], fields[:, [0, 2]])
    np.testing.assert_allclose(edges, [[0.7, 1.3], [0.1, 0.5], [-0.3, 0.1], [0.2, 0.2]], atol=1e-9)
