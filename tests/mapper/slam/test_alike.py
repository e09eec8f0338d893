"""Buildings in which many places look alike: recognized places may be wrong, and are then left out."""

import gc
from weakref import WeakSet

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.shapes import outer_walls, rect
from mapper.simulation.worlds import World
from mapper.slam import SlamConfig, SlamProgress, slam_log, whole_log
from mapper.slam.estimate import PASSES
from mapper.slam.map_agreement import APART, MapAgreement, map_agreement
from mapper.slam.scan_store import ScanStore
from tests.mapper.slam.worlds import along, drive

WIDE, DEEP = 52.0, 40.0
XS, YS = (1.4, 14.0, 26.5, 38.5, 50.6), (1.4, 13.0, 26.0, 38.6)  # the middles of the corridors
HALF = 1.2
SENSOR = SensorConfig(n_beams=120, field_of_view=2.0 * np.pi * 119 / 120, range_max=10.0, range_noise=0.02)
STEP, N_SCANS = 0.25, 1500
LEFT_OUT = "recognized places are left out"


def building(rng: np.random.Generator) -> World:
    """A grid of corridors between twelve blocks, with 160 things along their walls."""
    blocks = [
        (XS[i] + HALF, YS[j] + HALF, XS[i + 1] - HALF, YS[j + 1] - HALF) for i in range(4) for j in range(3)
    ]  # fmt: skip
    solids = [*outer_walls(0.0, 0.0, WIDE, DEEP, 0.2), *(rect(*block) for block in blocks)]
    for _ in range(160):
        i, j = rng.integers(4), rng.integers(3)
        x0, y0, x1, y1 = blocks[3 * i + j]
        size = rng.uniform(0.15, 0.5)
        if rng.random() < 0.5:
            x, y = rng.uniform(x0, x1), y0 if rng.random() < 0.5 else y1
        else:
            x, y = x0 if rng.random() < 0.5 else x1, rng.uniform(y0, y1)
        solids.append(rect(x - size, y - 0.7 * size, x + size, y + 0.7 * size))
    return World("alike", "Alike", (0.0, 0.0, WIDE, DEEP), tuple(solids), (XS[0], YS[0], 0.0))


def random_way(rng: np.random.Generator) -> np.ndarray:
    """Poses along the corridors, with a random turn at each crossing, never back."""
    i, j, before = 0, 0, None
    corners = [(XS[0], YS[0])]
    while len(corners) < N_SCANS // 40 + 3:
        nearby = [
            (a, b)
            for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))
            if 0 <= a < len(XS) and 0 <= b < len(YS) and (a, b) != before
        ]
        before = (i, j)
        i, j = nearby[rng.integers(len(nearby))]
        corners.append((XS[i], YS[j]))
    return along(corners, step=STEP)[:N_SCANS]


def drive_with(seed: int) -> ScanLog:
    world, path = building(np.random.default_rng(seed)), random_way(np.random.default_rng(seed))
    return drive(world, path, sensor=SENSOR, turn_bias=0.05, seed=seed)


def mean_error(log: ScanLog, poses: np.ndarray) -> float:
    true = log.trajectory("true").poses
    off = compose(inverse(true[:1]), true) - compose(inverse(poses[:1]), poses)
    return float(np.hypot(off[:, 0], off[:, 1]).mean())


@pytest.fixture(scope="module")
def alike() -> ScanLog:
    return drive_with(77)


@pytest.mark.long
def test_wrongly_recognized_places_are_left_out(alike: ScanLog, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(MapAgreement, "score", lambda *_: 0.0)
        assert mean_error(alike, slam_log(alike).poses) > 1.0
    seen: list[SlamProgress] = []
    found = slam_log(alike, progress=seen.append)
    assert mean_error(alike, found.poses) < 0.1
    assert any(LEFT_OUT in note for note in found.notes)
    left_out = [reason for reason in found.candidates.reason if "agrees better with itself without" in reason]
    assert len(left_out) >= 5
    fractions = [one.fraction for one in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] <= 1.0
    compared = [one for one in seen if one.stage == "comparison"]
    assert {one.scans_done for one in compared} == {alike.n_scans}
    alone = slam_log(alike, SlamConfig(place_recognition=False))
    assert np.array_equal(alone.poses, found.poses)


def test_stricter_rules_are_tried_where_the_map_contradicts_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Loops found in the wide window are wrong here, with recognized places and without."""
    log = drive_with(90)
    with monkeypatch.context() as patch:
        patch.setattr(whole_log, "STRICTER", {})
        wrong = slam_log(log)
    assert mean_error(log, wrong.poses) > 1.0
    assert any("loops may be wrong" in note for note in wrong.notes)
    passes: WeakSet[object] = WeakSet()
    at_once: list[int] = []

    class Counted(whole_log._Pass):
        def add_all(self, report: whole_log.Report | None) -> None:
            super().add_all(report)
            passes.add(self)
            gc.collect()
            at_once.append(len(passes))

    monkeypatch.setattr(whole_log, "_Pass", Counted)
    found = slam_log(log, progress=lambda _: True)
    assert len(at_once) > 3
    assert max(at_once) == PASSES, "the estimate of memory states as many"
    assert mean_error(log, found.poses) < 0.1
    assert any("A stricter rule for loops was used" in note for note in found.notes)
    assert not any("loops may be wrong" in note for note in found.notes)


def stored(log: ScanLog) -> ScanStore:
    store = ScanStore(sensors_of(log), SlamConfig().range_max, SENSOR.n_beams)
    for k in range(log.n_scans):
        store.append(log.ranges[k], 0, np.zeros(3), log.mount_of(k))
    return store


def test_the_map_along_the_true_poses_agrees_best(alike: ScanLog) -> None:
    """Along the true poses no point contradicts the others, along drifting ones many do."""
    store = stored(alike)
    true, drifting = (alike.trajectory(name).poses for name in ("true", "odometry"))
    along_true = map_agreement(store, true)
    for points, agreeing, contradicting in (along_true.far, along_true.near):
        assert contradicting < 0.001 * points < 0.9 * points < agreeing
    assert along_true.is_consistent
    assert along_true.score(0.12) == along_true.far[1] - along_true.far[2] / 0.12 > 0.0
    along_drifting = map_agreement(store, drifting)
    assert along_drifting.contradicted > 0.12 > along_drifting.contradicted_near
    assert not along_drifting.is_consistent
    assert along_drifting.score(0.12) < 0.0


def test_scans_that_never_meet_again_score_nothing(alike: ScanLog) -> None:
    log = alike.take(slice(0, int(0.9 * APART / STEP)))
    agreement = map_agreement(stored(log), log.trajectory("true").poses)
    assert agreement.far == (0, 0, 0)
    assert agreement.near[1] > 0.9 * agreement.near[0] > 0
    assert agreement.is_consistent
    assert agreement.score(0.12) == 0.0


@pytest.mark.parametrize(("off", "is_consistent"), [(0.0, True), (0.4, False)])
def test_a_second_round_is_compared_with_the_first_however_short_it_is(off: float, is_consistent: bool) -> None:
    """Two rounds of 9.6 m, the second of which is put beside the first."""
    corners = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4)]
    log = drive("room", along([*corners, *corners, corners[0]]), sensor=SENSOR)
    poses = log.trajectory("true").poses.copy()
    poses[log.n_scans // 2 :, 1] += off
    agreement = map_agreement(stored(log), poses)
    assert agreement.far[1] > 0
    assert agreement.is_consistent == is_consistent


def test_points_that_nobody_sees_again_say_nothing() -> None:
    """In rooms that are seen from another side most points are out of sight of the scans of before."""
    assert MapAgreement((1000, 900, 20), (1000, 950, 10)).is_consistent
    assert not MapAgreement((1000, 50, 20), (1000, 950, 10)).is_consistent
    assert MapAgreement((1000, 0, 0), (1000, 950, 10)).is_consistent
    assert MapAgreement((90, 82, 1), (1000, 950, 0)).is_consistent  # one point of 83, where the robot hardly came back
