"""SLAM of simulated drives with drifting odometry, against their true poses, and of one real log."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.parallel import single_threaded
from mapper.core.se2 import compose, inverse
from mapper.evaluation import absolute_errors, align, evaluate_relations
from mapper.io.logs import odometry_records, open_log
from mapper.io.trajectories import read_relations
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses
from mapper.slam import SlamCancelled, SlamConfig, SlamProgress, SlamResult, slam_log
from tests.mapper.slam.worlds import along, drive

RING = [(3.2, 1.25), (22.7, 1.25), (22.7, 14.7), (1.3, 14.7), (1.3, 1.25), (8.0, 1.25)]


@pytest.fixture(scope="module")
def ring() -> ScanLog:
    """One and a quarter rounds of a ring of corridors, of which the odometry is metres off in the end."""
    return drive("loop", along(RING, 0.45))


@pytest.fixture(scope="module")
def healed(ring: ScanLog) -> SlamResult:
    return slam_log(ring)


def errors(log: ScanLog, poses: np.ndarray) -> np.ndarray:
    """Distances of poses (n, 3) from the true ones after alignment, metres (n,)."""
    true = log.trajectory("true").poses
    return absolute_errors(true, align(true, poses).apply(poses))[0]


def test_a_loop_closure_removes_the_drift(ring: ScanLog, healed: SlamResult) -> None:
    assert healed.odometry == "odometry"
    assert errors(ring, ring.trajectory("odometry").poses).max() > 3.0
    assert healed.graph.n_loops >= 1
    assert errors(ring, healed.poses).max() < 0.3
    # Without loops the front end's drift stays.
    open_ended = slam_log(ring, SlamConfig(loop_closure=False, refinement=0))
    assert errors(ring, open_ended.poses).max() > 0.5


def test_the_graph_is_that_of_the_poses(ring: ScanLog, healed: SlamResult) -> None:
    graph, tried = healed.graph, healed.candidates
    np.testing.assert_array_equal(healed.poses[graph.nodes], graph.poses)
    assert healed.poses.shape == (ring.n_scans, 3)
    true = ring.trajectory("true").poses[graph.nodes]
    loops = np.flatnonzero(graph.kind == 1)
    off = compose(inverse(graph.relative[loops]), compose(inverse(true[graph.i[loops]]), true[graph.j[loops]]))
    # A corridor tells little along itself, and the loop's information says so.
    assert np.sqrt(np.einsum("ka,kab,kb->k", off, graph.information[loops], off)).max() < 5.0
    assert np.abs(off[:, 1]).max() < 0.05
    assert np.count_nonzero(tried.accepted) == len(loops)
    assert [not reason for reason in tried.reason] == tried.accepted.tolist()


def test_results_do_not_depend_on_threads_or_on_the_run(ring: ScanLog, healed: SlamResult) -> None:
    with single_threaded():
        alone = slam_log(ring)
    assert healed.poses.tobytes() == alone.poses.tobytes()
    assert healed.graph.information.tobytes() == alone.graph.information.tobytes()
    assert healed.candidates.score.tobytes() == alone.candidates.score.tobytes()


def test_progress_grows_and_false_cancels(ring: ScanLog) -> None:
    seen: list[SlamProgress] = []
    slam_log(ring, SlamConfig(refinement=2), progress=seen.append)
    assert [one.fraction for one in seen] == sorted(one.fraction for one in seen)
    assert {one.stage for one in seen} == {"front end", "loop closure", "refinement"}
    assert all(one.poses.shape == (one.scans_done, 3) for one in seen)
    assert seen[-1].scans_done == ring.n_scans
    with pytest.raises(SlamCancelled):
        slam_log(ring, progress=lambda one: one.fraction < 0.3)


@pytest.mark.data
def test_intel_is_as_good_as_the_best_published(data_file: Callable[[str], Path]) -> None:
    """910 scans of Intel: without loops the error is more than ten times the bound."""
    path = data_file("carmen/intel.log.gz")
    log = open_log(path)
    relations = read_relations(data_file("relations/intel.relations"))
    found = evaluate_relations(relations, TimedPoses(log.stamps_ns, slam_log(log).poses), odometry_records(path))
    translation, rotation = found.only_unambiguous()
    assert translation.statistics.mean < 0.0225
    assert np.degrees(rotation.statistics.mean) < 1.05
