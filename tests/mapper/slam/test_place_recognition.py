"""Loops that are off by more than the search window, in simulated drives and in a real log with worse odometry."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.parallel import single_threaded
from mapper.core.se2 import compose, inverse
from mapper.evaluation import absolute_errors, align
from mapper.io.logs import open_log
from mapper.sensors.pose_graph import LOOP
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.shapes import Polygon, outer_walls, rect
from mapper.simulation.worlds import World
from mapper.slam import SlamConfig, SlamResult, slam_log, whole_log
from mapper.slam.loop_closure import LoopCloser
from mapper.slam.map_agreement import MapAgreement
from mapper.slam.odometry import motions, odometry_name
from mapper.slam.place_recognition import reason_against_group
from tests.mapper.slam.worlds import along, drive

WIDE, DEEP, CORRIDOR = 44.0, 30.0, 2.4
MIDDLE = CORRIDOR / 2


def cupboards(x: float) -> list[Polygon]:
    """Furniture along the south corridor from x on, in an order that no other part of the ring has."""
    return [
        rect(x, 0.2, x + 0.6, 0.7), rect(x + 3.2, 2.0, x + 3.9, 2.5), rect(x + 5.0, 0.2, x + 6.3, 0.5),
        rect(x + 8.1, 1.7, x + 8.5, 2.5), rect(x + 11.0, 0.2, x + 11.4, 0.9),
    ]  # fmt: skip


def ring(*solids: Polygon) -> World:
    walls = (*outer_walls(0.0, 0.0, WIDE, DEEP, 0.2), rect(CORRIDOR, CORRIDOR, WIDE - CORRIDOR, DEEP - CORRIDOR))
    return World("ring", "Ring", (0.0, 0.0, WIDE, DEEP), (*walls, *solids), (4.0, MIDDLE, 0.0))


def round_trip(end: float, world: World, stretched: float, seed: int = 0) -> ScanLog:
    """Once round the ring and on to x = ``end``; the wheels report the east corridor longer by a factor."""
    low_x, high_x, high_y = MIDDLE, WIDE - MIDDLE, DEEP - MIDDLE
    corners = [(4.0, MIDDLE), (high_x, MIDDLE), (high_x, high_y), (low_x, high_y), (low_x, MIDDLE), (end, MIDDLE)]
    path = along(corners, 0.4)
    log = drive(world, path, turn_bias=0.0, seed=seed)
    steps = motions(log.trajectory("odometry").poses)
    steps[path[1:, 0] > WIDE - 2 * CORRIDOR, :2] *= stretched
    return replace(log, trajectories={"odometry": chained(path[0], steps), "true": Trajectory(path)})


def chained(first: np.ndarray, steps: np.ndarray) -> Trajectory:
    poses = [first]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return Trajectory(np.array(poses), "wheels", "odom")


def return_errors(log: ScanLog, poses: np.ndarray) -> np.ndarray:
    """Distances of the last 20 poses from those of the first round's nearest scans, metres."""
    true = log.trajectory("true").poses
    out = []
    for k in range(log.n_scans - 20, log.n_scans):
        first = int(np.argmin(np.hypot(*(true[:100, :2] - true[k, :2]).T)))
        off = compose(inverse(compose(inverse(true[first]), true[k])), compose(inverse(poses[first]), poses[k]))
        out.append(float(np.hypot(off[0], off[1])))
    return np.array(out)


def loop_errors(log: ScanLog, found: SlamResult) -> np.ndarray:
    """Error of each loop's relative pose, metres."""
    graph = found.graph
    true = log.trajectory("true").poses[graph.nodes]
    loops = np.flatnonzero(graph.kind == LOOP)
    off = compose(inverse(graph.relative[loops]), compose(inverse(true[graph.i[loops]]), true[graph.j[loops]]))
    return np.hypot(off[:, 0], off[:, 1])


@pytest.fixture(scope="module")
def drifted() -> ScanLog:
    return round_trip(22.0, ring(*cupboards(6.0)), 1.4)


@pytest.mark.parametrize("stretched", [0.6, 1.4, 1.55])
def test_a_loop_closes_that_is_off_by_more_than_the_search_window(stretched: float) -> None:
    log = round_trip(22.0, ring(*cupboards(6.0)), stretched)
    window_only = slam_log(log, SlamConfig(place_recognition=False))
    off = return_errors(log, window_only.poses)
    assert 6.0 < off.min() < off.max() < 16.0
    assert window_only.graph.n_loops == 0
    found = slam_log(log)
    assert found.graph.n_loops >= 5
    assert np.median(loop_errors(log, found)) < 0.1
    assert loop_errors(log, found).max() < 1.5  # along the corridor behind the cupboards a loop may slip
    assert return_errors(log, found.poses).max() < 0.2


def test_what_is_refused_names_the_stage_and_the_graph_gets_only_what_is_accepted(drifted: ScanLog) -> None:
    found = slam_log(drifted, SlamConfig(loop_score=0.95))
    told = [reason for reason in found.candidates.reason if reason.startswith("place recognition: ")]
    assert any("corners of an earlier submap correspond" in reason for reason in told)
    assert any("no pose in the window scores 0.95" in reason for reason in told)
    assert np.count_nonzero(found.candidates.accepted) == found.graph.n_loops


def test_the_parameters_say_what_is_enough(drifted: ScanLog) -> None:
    corners = slam_log(drifted, SlamConfig(place_corners=40))
    assert corners.graph.n_loops == 0
    assert any("corners of an earlier submap correspond" in reason for reason in corners.candidates.reason)
    assert slam_log(drifted, SlamConfig(place_length=15.0)).graph.n_loops >= 5
    with pytest.raises(ConfigError, match="place_group"):
        SlamConfig(place_group=1)


def test_a_place_needs_as_many_loops_as_the_group_says(drifted: ScanLog) -> None:
    """Shortly after the return some loops agree, but not yet 30."""
    log = drifted.take(slice(0, drifted.n_scans - 16))
    few, many = (slam_log(log, SlamConfig(place_group=least)) for least in (5, 30))
    waiting = many.candidates.reason.count("place recognition: too few other loops agree with it")
    assert few.graph.n_loops >= 5
    assert many.graph.n_loops == 0
    assert 5 <= waiting < 30


@pytest.mark.parametrize("stretched", [1.0, 1.5])
def test_two_places_that_look_alike_are_not_joined_after_a_long_drive(stretched: float) -> None:
    """The same cupboards stand 21 m farther on, and the robot comes back after 150 m: either could be the other."""
    log = round_trip(39.0, ring(*cupboards(6.0), *cupboards(27.0)), stretched, seed=1)
    found = slam_log(log)
    assert found.graph.n_loops >= 5
    assert loop_errors(log, found).max() < 5.0  # along the corridor between them a loop may slip


def test_results_do_not_depend_on_threads_or_on_the_run(drifted: ScanLog) -> None:
    found = slam_log(drifted)
    assert found.graph.n_loops
    with single_threaded():
        alone = slam_log(drifted)
    assert found.poses.tobytes() == alone.poses.tobytes()
    assert found.candidates.reason == alone.candidates.reason


def test_a_group_that_the_graph_does_not_bear_is_refused(drifted: ScanLog) -> None:
    graph = slam_log(drifted).graph
    before = replace(
        graph, i=graph.i[:-5], j=graph.j[:-5], relative=graph.relative[:-5], information=graph.information[:-5],
        kind=graph.kind[:-5], locked=graph.locked[:-5], residual=graph.residual[:-5], weight=np.ones(len(graph.i) - 5),
    )  # fmt: skip
    weight = np.ones(len(graph.i))
    assert not reason_against_group(before, replace(graph, weight=weight))
    weight[-1] = 0.1
    assert "the rest of the graph" in reason_against_group(before, replace(graph, weight=weight))
    weight[-1], weight[-9:-6] = 1.0, 0.1
    assert "contradict 3 loops" in reason_against_group(before, replace(graph, weight=weight))


def with_worse_odometry(log: ScanLog, scale: float, noise: float, turn: float) -> ScanLog:
    """The log with wheels that report each metre as ``scale``, each step off by a share, and turn more by the metre."""
    wheels = log.trajectory(odometry_name(log)).poses
    steps, rng = motions(wheels), np.random.default_rng(1)
    way = np.hypot(steps[:, 0], steps[:, 1])
    steps[:, :2] *= (scale + noise * rng.standard_normal(len(steps)))[:, np.newaxis]
    steps[:, 2] += turn * way + 0.02 * np.sqrt(way) * rng.standard_normal(len(steps))
    return replace(log, trajectories={"odometry": chained(wheels[0], steps)})


def mean_error(expected: np.ndarray, poses: np.ndarray) -> float:
    return float(absolute_errors(expected, align(expected, poses).apply(poses))[0].mean())


@pytest.mark.data
def test_a_real_log_with_worse_odometry(data_file: Callable[[str], Path]) -> None:
    """ACES with wheels that turn by 0.15 rad more for each metre, and report 20 % more way, each step off by 30 %."""
    log = open_log(data_file("carmen/aces.log.gz"))
    expected = slam_log(log).poses
    worse = with_worse_odometry(log, 1.2, 0.3, 0.15)
    assert mean_error(expected, slam_log(worse, SlamConfig(place_recognition=False)).poses) > 2.0
    assert mean_error(expected, slam_log(worse).poses) < 0.6


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "odometry"),
    [
        pytest.param("aces", (1.15, 0.1, -0.15), marks=pytest.mark.long),
        pytest.param("fhw", (0.9, 0.2, 0.12), marks=pytest.mark.long),
        pytest.param("fhw", (1.15, 0.1, -0.15), marks=pytest.mark.long),
    ],
)
def test_the_way_to_a_wrong_loop_refuses_it(
    name: str,
    odometry: tuple[float, float, float],
    data_file: Callable[[str], Path],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One scan fits another place within the wide search window; accepted, the loop makes the map wrong by metres."""
    log = open_log(data_file(f"carmen/{name}.log.gz"))
    expected = slam_log(log).poses
    worse = with_worse_odometry(log, *odometry)
    with monkeypatch.context() as patch:
        patch.setattr(LoopCloser, "_checked", lambda _closer, loop, *_: loop)
        # Without these the map that contradicts itself is made again with a stricter rule.
        patch.setattr(whole_log, "STRICTER", {})
        patch.setattr(MapAgreement, "score", lambda *_: 0.0)
        assert mean_error(expected, slam_log(worse).poses) > 2.0
    found = slam_log(worse)
    assert any(reason.startswith("on the way there ") for reason in found.candidates.reason)
    assert mean_error(expected, found.poses) < 0.6
