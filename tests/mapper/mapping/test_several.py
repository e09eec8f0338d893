"""Two lidars of one robot make one map, in the order of time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import bounds_of_logs, geometry_for, integrate_log, integrate_logs, integrate_scan
from mapper.mapping.joint_scans import SensorOrder, planned_parts
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import provenance
from mapper.sensors.joint_log import JointLog, scan_order
from mapper.sensors.scan import ScanLog, Trajectory
from tests.mapper.mapping.sweeping import HALF, off_the_walls, to_the_walls, true_poses

ONLY_HITS = {"hit_and_passed": "only_hits"}
MOUNTS = {"front": (0.3, 0.1, 0.0), "rear": (-0.4, 0.0, 3.0)}


def seen_by(mount: tuple[float, float, float], rate: float, delay: float = 0.0) -> ScanLog:
    """Scans of half a turn, each taken at one moment."""
    times = 100.0 + delay + np.arange(int(4.0 * rate)) / rate
    bases = true_poses(times)
    bearings = np.zeros((180, 3))
    bearings[:, 2] = np.radians(np.arange(180) - 90.0)
    ranges = to_the_walls(compose(compose(bases, np.array(mount))[:, np.newaxis], bearings)).astype(np.float32)
    return ScanLog(
        ranges,
        -np.pi / 2,
        np.pi / 180,
        0.05,
        20.0,
        np.round(times * 1e9).astype(np.int64),
        {"true": Trajectory(bases, frame_id="odom")},
        mount=mount,
    )


def first_of(log: ScanLog, n: int) -> ScanLog:
    poses = {"true": Trajectory(log.trajectory().poses[:n])}
    return replace(log, ranges=log.ranges[:n], stamps_ns=log.stamps_ns[:n], trajectories=poses)


@pytest.fixture(scope="module")
def logs() -> list[ScanLog]:
    return [seen_by(MOUNTS["front"], 10.0), seen_by(MOUNTS["rear"], 7.0, 0.013)]


def made(logs: list[ScanLog], config: MappingConfig, count: int | None = None) -> OccupancyGrid:
    geometry = geometry_for(logs[0], config, bounds_of=lambda _, config, name: bounds_of_logs(logs, config, name))
    grid = OccupancyGrid(geometry)
    integrate_logs(grid, logs, config, count=count)
    return grid


def other_beams(log: ScanLog) -> ScanLog:
    """The same scans with a third of the beams, from the other end, and other limits."""
    return replace(
        log, ranges=log.ranges[:, ::-3].copy(), angle_min=-log.angle_min, angle_increment=-3 * log.angle_increment,
        range_min=0.6, range_max=3.5,
    )  # fmt: skip


def one_by_one(logs: list[ScanLog], config: MappingConfig, grid: OccupancyGrid) -> OccupancyGrid:
    expected = OccupancyGrid(grid.geometry)
    scans = sorted((log.stamps_ns[t], k, t) for k, log in enumerate(logs) for t in range(log.n_scans))
    for _, k, t in scans:
        if logs[k].time_increment:
            integrate_log(expected, logs[k], config, None, t, t + 1)
        else:
            integrate_scan(expected, logs[k].scan(t), logs[k].sensor_poses()[t], config)
    assert expected.geometry == grid.geometry
    return expected


@pytest.mark.parametrize(
    ("rear", "values"),
    [
        ("alike", {}),
        ("alike", {"update": "per_scan"}),
        ("alike", {"model": "hit_counting"}),
        ("swept", {}),
        ("both swept", {}),
        ("other beams", {}),
        ("other beams", {"traversal": "amanatides_woo"}),
        ("other beams", {"update": "per_scan"}),
        ("other beams", {"no_return": "free"}),
        ("other beams", {"no_return": "hit"}),
        ("other beams", {"update": "per_scan", "model": "hit_counting"}),
        ("other beams", {"update": "per_scan", "model": "smooth_ramp", "range_max": 2.0}),
        ("other beams", {"model": "sonar_cone", "range_max": 2.0}),
        ("other beams", {"model": "moravec_elfes", "range_max": 2.0}),
        ("other beams, swept", {}),
        ("swept", ONLY_HITS),
        ("both swept", ONLY_HITS),
        ("other beams", ONLY_HITS),
        ("other beams, swept", ONLY_HITS | {"traversal": "amanatides_woo"}),
        ("other beams, swept", {"no_return": "free", "model": "smooth_ramp"}),
    ],
)
def test_the_map_is_that_of_the_scans_one_by_one_in_the_order_of_time(
    logs: list[ScanLog], rear: str, values: dict[str, object]
) -> None:
    logs = [first_of(log, 12) for log in logs]
    if rear.startswith("other beams"):
        logs[1] = replace(other_beams(logs[1]), time_increment=1e-4 if "swept" in rear else 0.0)
    elif rear != "alike":
        logs = [replace(log, time_increment=1e-4 if "both" in rear or k else 0.0) for k, log in enumerate(logs)]
    # With a tight clamp the order of the scans matters.
    config = MappingConfig(resolution=0.1).with_values({"log_odds_max": 1.0, **values})
    grid = made(logs, config)
    expected = one_by_one(logs, config, grid)
    np.testing.assert_array_equal(grid.log_odds, expected.log_odds)
    np.testing.assert_array_equal(grid.observed, expected.observed)

    joint = JointLog.of(logs)
    again = OccupancyGrid(geometry_for(joint, config))
    assert again.geometry == grid.geometry
    for start, stop in ((0, 1), (1, 14), (14, joint.n_scans)):
        integrate_log(again, joint, config, None, start, stop)
    np.testing.assert_array_equal(again.log_odds, expected.log_odds)
    assert len(list(planned_parts(SensorOrder.of(joint), config, None, 0, joint.n_scans))) == 1, "all scans at once"
    for row, col in np.argwhere(grid.observed)[::400].tolist():
        told = provenance(grid.geometry, joint, config, (row, col))
        assert told.after == grid.log_odds[row, col]
        assert (np.diff(told.scans) >= 0).all()
        for scan, beam, reading in zip(told.scans.tolist(), told.beams.tolist(), told.ranges.tolist(), strict=True):
            assert joint.scan(scan).ranges[beam] == reading


def test_both_lidars_see_the_true_walls(logs: list[ScanLog]) -> None:
    both = made(logs, MappingConfig())
    assert np.quantile(off_the_walls(both), 0.99) < 0.06
    few = [first_of(log, 3) for log in logs]
    walls = [len(off_the_walls(made(part, MappingConfig()))) for part in (few, few[:1], few[1:])]
    assert walls[0] > 1.5 * max(walls[1:]), "one looks ahead, the other behind"
    low, high = bounds_of_logs(logs, MappingConfig())
    np.testing.assert_allclose([low, high], [-HALF, HALF], atol=0.01)


def test_the_first_scans_are_the_earliest(logs: list[ScanLog]) -> None:
    parts, scans = scan_order(logs)
    assert list(zip(parts[:5].tolist(), scans[:5].tolist(), strict=True)) == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2)]
    assert len(parts) == sum(log.n_scans for log in logs)


def test_scans_with_stamps_that_jump_back_keep_the_order_of_the_file(logs: list[ScanLog]) -> None:
    stamps = logs[0].stamps_ns.copy()
    stamps[5] = stamps[2]
    parts, scans = scan_order([replace(logs[0], stamps_ns=stamps), logs[1]])
    assert scans[parts == 0].tolist() == list(range(len(stamps)))


def test_a_joint_log_is_a_log(logs: list[ScanLog]) -> None:
    narrow = other_beams(logs[1])
    joint = JointLog.of([logs[0], narrow])
    assert (joint.n_scans, joint.n_beams) == (logs[0].n_scans + narrow.n_scans, 180)
    assert (np.diff(joint.stamps_ns) >= 0).all()
    for t in (0, 1, 7, joint.n_scans - 1):
        part, own = joint.parts[joint.part_of_scan[t]], int(joint.scan_of_part[t])
        assert joint.stamps_ns[t] == part.stamps_ns[own]
        np.testing.assert_array_equal(joint.scan(t).ranges, part.scan(own).ranges)
        np.testing.assert_array_equal(joint.sensor_poses()[t], part.sensor_poses()[own])
        np.testing.assert_array_equal(joint.trajectory().poses[t], part.trajectory().poses[own])
    moved = replace(joint, trajectories={**joint.trajectories, "moved": Trajectory(joint.trajectory().poses + 1.0)})
    np.testing.assert_array_equal(moved.parts[1].trajectory("moved").poses, narrow.trajectory().poses + 1.0)
    few = joint.take(np.arange(10, 20))
    np.testing.assert_array_equal(few.stamps_ns, joint.stamps_ns[10:20])
    np.testing.assert_array_equal(few.sensor_poses(), joint.sensor_poses()[10:20])
    assert joint.notes == ()
    other_clock = replace(narrow, stamps_ns=narrow.stamps_ns + 10**12, topic="/rear")
    (note,) = JointLog.of([replace(logs[0], topic="/front"), other_clock]).notes
    assert note.startswith("All scans of /rear are later than those of /front")
    with pytest.raises(ConfigError, match="Sonars and lidars"):
        JointLog.of([logs[0], replace(narrow, beam_width=0.3)])
    strange = replace(narrow, trajectories={"true": replace(narrow.trajectory(), frame_id="map")})
    with pytest.raises(ConfigError, match="in one frame"):
        JointLog.of([logs[0], strange])


def test_too_many_scans_and_a_missing_trajectory_are_refused(logs: list[ScanLog]) -> None:
    grid = made(logs, MappingConfig(), 0)
    with pytest.raises(ConfigError, match=r"no scans 0 to 1000; they have 68"):
        integrate_logs(grid, logs, MappingConfig(), count=1000)
    other = replace(logs[1], trajectories={"another": logs[1].trajectory()})
    with pytest.raises(ConfigError, match="no trajectory 'true'"):
        integrate_logs(grid, [logs[0], other], MappingConfig(), "true")
