"""The motion and the readings of a log from scan to scan, against a loop over its scans."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.io.contents import scan_series as module
from mapper.io.contents.scan_series import has_times, scan_series
from mapper.io.logs import open_log
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog, Trajectory

INF, NAN = math.inf, math.nan


def log_of(stamps_s: list[float], poses: list[tuple[float, float, float]], ranges: list[list[float]]) -> ScanLog:
    return ScanLog(
        ranges=np.array(ranges, dtype=np.float32),
        angle_min=0.0,
        angle_increment=0.1,
        range_min=0.5,
        range_max=10.0,
        stamps_ns=(np.array(stamps_s) * 1e9).astype(np.int64),
        trajectories={"odom": Trajectory(np.array(poses))},
    )


def by_a_loop(log: ScanLog) -> dict[str, list[float]]:
    """Each number of each scan in the file's order, from its definition."""
    poses = log.trajectory().poses
    out: dict[str, list[float]] = {name: [] for name in ("speed", "turn rate", "returns", "pose step", "interval")}
    for scan in range(log.n_scans):
        readings = [float(r) for r in log.ranges[scan]]
        out["returns"].append(100.0 * sum(log.range_min <= r <= log.range_max for r in readings) / len(readings))
        if scan == 0:
            for name in ("speed", "turn rate", "pose step", "interval"):
                out[name].append(NAN)
            continue
        seconds = (int(log.stamps_ns[scan]) - int(log.stamps_ns[scan - 1])) * 1e-9
        metres = math.dist(poses[scan][:2], poses[scan - 1][:2])
        turned = math.remainder(poses[scan][2] - poses[scan - 1][2], 2.0 * math.pi)
        out["pose step"].append(metres)
        out["interval"].append(seconds)
        out["speed"].append(metres / seconds if seconds > 0.0 else NAN)
        out["turn rate"].append(turned / seconds if seconds > 0.0 else NAN)
    return out


def test_a_turn_across_pi_a_pause_and_readings_of_all_kinds() -> None:
    log = log_of(
        [0.0, 0.5, 0.5, 4.5],
        [(0.0, 0.0, 3.0), (3.0, 4.0, -3.0), (3.0, 4.0, -3.0), (3.0, 6.0, -2.0)],
        [[1.0, 2.0, INF, NAN], [0.4, 10.0, 0.5, 10.1], [-INF] * 4, [1.0] * 4],
    )
    series = scan_series(log)
    found = {column.label: series.values[:, n].tolist() for n, column in enumerate(series.columns)}
    assert found["speed"] == pytest.approx([NAN, 10.0, NAN, 0.5], nan_ok=True)
    assert found["turn rate"] == pytest.approx([NAN, (2.0 * math.pi - 6.0) / 0.5, NAN, 0.25], nan_ok=True)
    assert found["returns"] == [50.0, 50.0, 0.0, 100.0]
    assert found["pose step"] == pytest.approx([NAN, 5.0, 0.0, 2.0], nan_ok=True)
    assert found["interval"] == pytest.approx([NAN, 0.5, 0.0, 4.0], nan_ok=True)
    assert [column.unit for column in series.columns] == ["m/s", "rad/s", "m", "%", "s"]


@pytest.mark.parametrize("name", ["carmen/intel.log.gz", "breezyslam/exp1.dat.gz"])
def test_real_logs_as_by_a_loop(data_file: Callable[[str], Path], name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "BLOCK_READINGS", 1 << 14)  # several blocks
    log = open_log(data_file(name)).take(slice(0, 300))
    series = scan_series(log)
    expected, order = by_a_loop(log), np.argsort(log.stamps_ns, kind="stable")
    assert series.stamps_ns.tolist() == log.stamps_ns[order].tolist()
    for n, column in enumerate(series.columns):
        np.testing.assert_allclose(series.values[:, n], np.array(expected[column.label])[order], rtol=1e-5, atol=1e-6)


def test_without_times_the_stamps_are_numbers_of_scans() -> None:
    log = log_of([7.0] * 3, [(0.0, 0.0, 0.0), (1.0, 0.0, 0.5), (1.0, 2.0, 0.0)], [[1.0]] * 3)
    series = scan_series(log)
    assert not has_times(log)
    assert (series.stamps_ns // 1_000_000_000).tolist() == [0, 1, 2]
    assert [column.label for column in series.columns] == ["turn", "pose step", "returns"]
    assert series.values[1:, 0].tolist() == pytest.approx([0.5, -0.5])


def test_nothing_is_told_of_the_motion_of_a_log_without_poses() -> None:
    log = log_of([0.0, 1.0], [(0.0, 0.0, 0.0)] * 2, [[1.0]] * 2)
    alone = replace(log, trajectories={"none": replace(log.trajectory(), is_placeholder=True)})
    assert [column.label for column in scan_series(alone).columns] == ["returns", "interval"]


def test_each_of_several_lidars_by_its_own_beams_and_limits() -> None:
    front = replace(log_of([0.0, 2.0], [(0.0, 0.0, 0.0)] * 2, [[1.0, 20.0, 1.0, 1.0]] * 2), topic="/front")
    rear = replace(log_of([1.0, 3.0], [(0.0, 0.0, 0.0)] * 2, [[20.0, 1.0]] * 2), topic="/rear", range_max=30.0)
    series = scan_series(JointLog.of([front, rear]))
    returns = next(n for n, column in enumerate(series.columns) if column.label == "returns")
    assert series.values[:, returns].tolist() == [75.0, 100.0, 75.0, 100.0]


def test_a_log_of_one_scan_has_readings_and_no_motion() -> None:
    series = scan_series(log_of([5.0], [(1.0, 1.0, 0.0)], [[1.0]]))
    assert len(series.stamps_ns) == 1
    assert np.isnan(series.values[0, :2]).all()
