"""Relations: closed forms, and the figures of another program for the Intel log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.evaluation import Relations, evaluate_relations
from mapper.evaluation.relations import poses_at_records
from mapper.io.logs import odometry_records, open_log
from mapper.io.trajectories import read_relations
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

S = 1_000_000_000
INTEL = "relations/intel.relations"
#: What another program for this metric, also in record order, printed: mean and std of translation (m) and of rotation
#: (°), over all 2,984 relations and over the 1,050 unambiguous ones.
RECORD_ORDER = {
    "raw odometry": ((7.370386, 14.348763, 39.153145, 53.801402), (7.142295, 13.804881, 41.091846, 54.457042)),
    "gmapping": ((0.029911, 0.021716, 1.104852, 1.127181), (0.028019, 0.020015, 1.029294, 0.975397)),
}
#: of the same, for intel_merged.log.gz without its ODOM messages
IN_TIME = (7.406913, 14.332264, 39.722658, 53.436533)


def circle(n: int) -> np.ndarray:
    """Poses of a robot that drives 0.1 m and turns by 0.05 rad from one to the next."""
    poses = np.zeros((n, 3))
    for k in range(1, n):
        poses[k] = compose(poses[k - 1], [0.1, 0.0, 0.05])
    return poses


def relations_of(poses: np.ndarray, stamps_ns: np.ndarray, pairs: list[tuple[int, int]]) -> Relations:
    a, b = np.array(pairs).T
    return Relations(np.column_stack([stamps_ns[a], stamps_ns[b]]), compose(inverse(poses[a]), poses[b]))


def test_true_poses_have_no_error_in_any_frame() -> None:
    poses, stamps = circle(50), np.arange(50) * S
    relations = relations_of(poses, stamps, [(0, 10), (10, 11), (40, 3)])
    found = evaluate_relations(relations, TimedPoses(stamps, compose([5.0, 6.0, 2.0], poses)))
    assert (found.policy, found.left_out) == ("time", 0)
    np.testing.assert_allclose(found.translation.errors, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.rotation.errors, 0.0, atol=1e-12)


def test_an_error_of_one_pose_appears_in_its_relations() -> None:
    poses, stamps = circle(50), np.arange(50) * S
    relations = relations_of(poses, stamps, [(0, 10), (10, 20), (20, 30)])
    estimate = poses.copy()
    estimate[20] = compose(poses[20], [0.03, 0.04, 0.1])
    found = evaluate_relations(relations, TimedPoses(stamps, estimate))
    assert found.translation.errors[:2].tolist() == pytest.approx([0.0, 0.05])
    np.testing.assert_allclose(found.rotation.errors, [0.0, 0.1, 0.1], atol=1e-12)


def test_relations_at_other_times_are_left_out_and_counted() -> None:
    poses, stamps = circle(50), np.arange(50) * S
    relations = relations_of(poses, stamps, [(0, 10), (10, 20), (20, 30)])
    found = evaluate_relations(relations, TimedPoses(stamps[:25], poses[:25]))
    assert (len(found.translation.errors), found.left_out) == (2, 1)
    with pytest.raises(ConfigError, match="No relation"):
        evaluate_relations(relations, TimedPoses(stamps + 1000 * S, poses))


def test_poses_at_records_follow_the_odometry_between_scans() -> None:
    true = circle(100)
    rng = np.random.default_rng(1)
    messages = TimedPoses(np.zeros(100, dtype=np.int64), compose([1.0, 2.0, 3.0], true))
    before = np.sort(rng.choice(100, 20, replace=False))
    records = OdometryRecords(messages, np.concatenate([[-1], before, before[-1:]]))
    scans = np.concatenate([[[9.0, 9.0, 9.0]], true[before], [[8.0, 8.0, 8.0]]])
    np.testing.assert_allclose(poses_at_records(records, scans), true, atol=1e-9)


def test_one_scan_carries_all_records() -> None:
    true = circle(20)
    records = OdometryRecords(TimedPoses(np.arange(20) * S, true), np.array([7]))
    moved = compose([1.0, -2.0, 0.5], true)
    np.testing.assert_allclose(poses_at_records(records, moved[7:8]), moved, atol=1e-9)


def test_of_records_with_one_stamp_the_one_that_fits_the_odometry_is_used() -> None:
    true, stamps = circle(60), np.arange(60) * S // 10
    stamps[30:33] = stamps[30]  # three messages with one stamp
    records = OdometryRecords(TimedPoses(stamps, true), np.arange(60))
    relations = relations_of(true, stamps, [(10, 32), (32, 45), (5, 9)])
    found = evaluate_relations(relations, TimedPoses(stamps, true), records)
    assert found.policy == "records"
    assert found.unambiguous.tolist() == [False, False, True]
    np.testing.assert_allclose(found.translation.errors, 0.0, atol=1e-12)
    translation, rotation = found.only_unambiguous()
    assert (len(translation.errors), rotation.stamps_ns.tolist()) == (1, [stamps[5]])


def test_relations_of_no_use_are_refused() -> None:
    poses, stamps = circle(5), np.arange(5) * S
    relations = relations_of(poses, stamps, [(0, 1)])
    records = OdometryRecords(TimedPoses(stamps, poses), np.arange(5))
    with pytest.raises(ConfigError, match="5 scans need as many poses, not 4"):
        evaluate_relations(relations, TimedPoses(stamps[:4], poses[:4]), records)
    with pytest.raises(ConfigError, match="no relations"):
        evaluate_relations(Relations(np.empty((0, 2), dtype=np.int64), np.empty((0, 3))), TimedPoses(stamps, poses))
    with pytest.raises(ConfigError, match="two stamps each"):
        Relations(np.zeros((3, 1), dtype=np.int64), np.zeros((3, 3)))


@pytest.mark.parametrize("poses", RECORD_ORDER)
def test_intel_in_record_order(data_file: Callable[[str], Path], poses: str) -> None:
    path = data_file("carmen/intel.log.gz")
    judged = open_log(path if poses == "raw odometry" else data_file("carmen/intel-corrected.log.gz"))
    records = odometry_records(path)
    assert records is not None
    assert len(records.messages) == 13_631
    found = evaluate_relations(
        read_relations(data_file(INTEL)), TimedPoses(judged.stamps_ns, judged.trajectory("scan").poses), records
    )
    assert (found.policy, found.left_out) == ("records", 0)
    every, clear = RECORD_ORDER[poses]
    for (translation, rotation), expected, count in (
        ((found.translation, found.rotation), every, 2984),
        (found.only_unambiguous(), clear, 1050),
    ):
        t, r = translation.statistics, rotation.statistics
        assert len(translation.errors) == count
        # The program was given the poses in TUM files, with six decimals.
        assert (t.mean, t.std, *np.degrees([r.mean, r.std])) == pytest.approx(expected, abs=5e-6)


def test_intel_in_time(data_file: Callable[[str], Path]) -> None:
    log = open_log(data_file("carmen/intel_merged.log.gz"))
    scans = TimedPoses(log.stamps_ns, log.trajectory("scan").poses)
    found = evaluate_relations(read_relations(data_file(INTEL)), scans)
    t, r = found.translation.statistics, found.rotation.statistics
    assert (found.policy, len(found.translation.errors)) == ("time", 2984)
    assert (t.mean, t.std, *np.degrees([r.mean, r.std])) == pytest.approx(IN_TIME, abs=5e-6)


def test_restarts_of_a_corrected_log_are_no_records(data_file: Callable[[str], Path]) -> None:
    """The corrected log is the raw one with a message more for each scan, which restarts the odometry from there."""
    raw = odometry_records(data_file("carmen/intel.log.gz"))
    corrected = odometry_records(data_file("carmen/intel-corrected.log.gz"))
    assert raw is not None
    assert corrected is not None
    assert abs(len(corrected.messages) - len(raw.messages)) < 20
    assert len(corrected.before_scan) == len(raw.before_scan) == 910


def test_logs_without_odometry_messages_have_no_records(tmp_path: Path) -> None:
    carmen = tmp_path / "a.log"
    carmen.write_text("FLASER 2 1.0 1.0 0 0 0 0 0 0 1 host 1\n")
    csv = tmp_path / "a.csv"
    csv.write_text("angle_min,0\nangle_increment,0.1\nstamp,x,y,theta,ranges\n1,0,0,0,1,1\n")
    assert odometry_records(carmen) is None
    assert odometry_records(csv) is None
