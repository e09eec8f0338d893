"""Loops in plain corridors, where one scan fits another place as well as its own."""

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.pose_graph import LOOP
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.shapes import outer_walls, rect
from mapper.simulation.worlds import World
from mapper.slam import SlamConfig, slam_log
from mapper.slam.loop_test import Loop, Place, share_contradicted_mutually
from mapper.slam.odometry import motions
from mapper.slam.scan_store import ScanStore
from tests.mapper.slam.worlds import along, drive

WIDE, DEEP, CORRIDOR = 44.0, 16.0, 2.4
MIDDLE = CORRIDOR / 2
ALL_ROUND = SensorConfig(n_beams=180, field_of_view=2.0 * np.pi, range_max=8.0, range_noise=0.02)
THINGS = rect(8.0, 0.2, 9.0, 0.6), rect(30.0, 15.3, 31.0, 15.8), rect(43.3, 8.0, 43.8, 8.7), rect(16.0, 2.1, 17.0, 2.4)
WORLD = World(
    "ring", "Ring", (0.0, 0.0, WIDE, DEEP),
    (*outer_walls(0.0, 0.0, WIDE, DEEP, 0.2), rect(CORRIDOR, CORRIDOR, WIDE - CORRIDOR, DEEP - CORRIDOR), *THINGS),
    (MIDDLE, MIDDLE, 0.0),
)  # fmt: skip


def chained(first: np.ndarray, steps: np.ndarray) -> np.ndarray:
    poses = [first]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


@pytest.mark.parametrize(("stretched", "seed"), [(0.7, 0), (1.15, 1), (1.35, 0)])
def test_a_scan_in_a_corridor_is_not_joined_to_another_part_of_it(stretched: float, seed: int) -> None:
    """Back in the plain west corridor after 110 m, with 2 to 3 m of drift."""
    far_x, far_y = WIDE - MIDDLE, DEEP - MIDDLE
    corners = [(MIDDLE, MIDDLE), (far_x, MIDDLE), (far_x, far_y), (MIDDLE, far_y), (MIDDLE, MIDDLE), (6.0, MIDDLE)]
    path = along(corners, 0.3)
    log = drive(WORLD, path, sensor=ALL_ROUND, turn_bias=0.0, seed=seed)
    steps = motions(log.trajectory("odometry").poses)
    steps[path[1:, 0] > WIDE - 2 * CORRIDOR, :2] *= stretched
    graph = slam_log(
        replace(log, trajectories={"odometry": Trajectory(chained(path[0], steps), "wheels", "odom")})
    ).graph
    loops = np.flatnonzero(graph.kind == LOOP)
    assert len(loops) >= 5
    true = path[graph.nodes]
    off = compose(inverse(graph.relative[loops]), compose(inverse(true[graph.i[loops]]), true[graph.j[loops]]))
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.2


@pytest.fixture(scope="module")
def in_corridor() -> ScanLog:
    """Along the west corridor to its end, then a scan from 7 m before that end, which it still sees."""
    path = np.array([(MIDDLE, y, -np.pi / 2) for y in (*np.arange(5.0, 1.0, -0.4), 7.6)])
    return drive(WORLD, path, sensor=ALL_ROUND)


@pytest.mark.parametrize(("shift", "low", "high"), [(0.0, 0.0, 0.02), (5.0, 0.1, 1.0)])
def test_what_a_scan_should_have_seen_counts_against_a_loop(
    in_corridor: ScanLog, shift: float, low: float, high: float
) -> None:
    store = ScanStore(sensors_of(in_corridor), 30.0, 360)
    for ranges in in_corridor.ranges:
        store.append(ranges)
    true = in_corridor.trajectory("true").poses
    last = len(true) - 1
    place = Place.of(store, np.arange(last), true[:last], 30.0)
    relative = compose(inverse(true[0]), true[last] - [0.0, shift, 0.0])
    loop = Loop(0, last, 0.9, 0.9, "", relative, np.eye(3))
    assert low <= share_contradicted_mutually(store, place, loop) <= high


@pytest.mark.parametrize("is_carried", [False, True])
def test_a_map_that_contradicts_itself_is_said_to_where_no_loop_is_wrong_either(is_carried: bool) -> None:
    """A robot that was carried away goes on where the odometry has it: there is no loop to refuse."""
    log = drive("office", along([(6.2, 7.0), (14.0, 7.0), (2.5, 7.0), (14.0, 7.0)]), sensor=ALL_ROUND, turn_bias=0.0)
    if is_carried:
        half = log.n_scans // 2
        steps = motions(log.trajectory("odometry").poses)
        steps[half - 1] = 0.0
        log = log.take(np.r_[0:half, half + 12 : log.n_scans])
        steps = np.r_[steps[:half], steps[half + 12 :]]
        wheels = Trajectory(chained(log.trajectory("odometry").poses[0], steps), "wheels", "odom")
        log = replace(log, trajectories={**log.trajectories, "odometry": wheels})
    found = slam_log(log, SlamConfig(loop_closure=False))
    assert any("poses may be wrong" in note for note in found.notes) == is_carried
