"""Scans on the way to a loop agree with the place of a true loop and contradict that of a wrong one."""

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog
from mapper.slam.loop_test import Loop
from mapper.slam.scan_store import ScanStore
from mapper.slam.way_test import BEFORE, graph_ways, share_contradicted
from tests.mapper.slam.worlds import along, drive

ROOM = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)]


def loop(i: int, j: int, relative: np.ndarray) -> Loop:
    return Loop(i, j, 0.9, 0.9, "", relative, np.eye(3))


@pytest.fixture(scope="module")
def rounds() -> ScanLog:
    """Three rounds of a room."""
    return drive("room", along([*ROOM[:1], *(ROOM[1:] * 3)], 0.3))


def test_the_way_to_a_true_loop_contradicts_nothing_and_that_to_a_wrong_one_does(rounds: ScanLog) -> None:
    store = ScanStore(sensors_of(rounds), 30.0, 360)
    for ranges in rounds.ranges:
        store.append(ranges)
    true = rounds.trajectory("true").poses
    way = np.r_[0.0, np.cumsum(np.hypot(*np.diff(true[:, :2], axis=0).T))]
    # The last 15 m have drifted away; the loop says by how much.
    drifted = true.copy()
    late = way > way[-1] - 15.0
    drifted[late] = compose([2.5, -1.0, 0.6], true[late])
    j, i = len(true) - 1, int(np.argmin(np.abs(way - way[-1] / 3.0)))
    relative = compose(inverse(true[i]), true[j])
    earlier = way < way[-1] - BEFORE - 8.0
    right = share_contradicted(store, [loop(i, j, relative)], drifted, way, earlier)
    wrong = share_contradicted(store, [loop(i, j, compose(relative, [1.5, 0.5, 0.8]))], drifted, way, earlier)
    assert right < 0.05
    assert wrong > 0.2
    # Without earlier scans nothing tells.
    assert share_contradicted(store, [loop(i, j, relative)], drifted, way, np.zeros(len(way), dtype=np.bool_)) == 0.0


def test_the_way_in_the_graph_is_short_across_a_loop() -> None:
    way = np.arange(100.0)
    np.testing.assert_allclose(graph_ways(10, way, []), np.abs(way - 10.0))
    across = graph_ways(10, way, [loop(12, 80, np.zeros(3)), loop(50, 90, np.zeros(3))])
    assert across[80] == 2.0
    assert across[90] == 12.0
    assert across[50] == 12.0
