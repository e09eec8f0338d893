"""Poses as TUM text, read with NumPy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mapper.io.export import tum_text
from mapper.sensors.scan import ScanLog


def test_tum_against_numpy(tmp_path: Path, log: ScanLog) -> None:
    path = tmp_path / "a.tum"
    path.write_text(tum_text(log, "true"))
    rows = np.loadtxt(path)
    poses = log.trajectory("true").poses
    np.testing.assert_allclose(rows[:, 0], log.stamps_ns / 1e9, atol=1e-6)
    np.testing.assert_allclose(rows[:, 1:3], poses[:, :2], atol=1e-6)
    assert not rows[:, 3:6].any()
    np.testing.assert_allclose(np.hypot(rows[:, 6], rows[:, 7]), 1.0, atol=1e-8)
    np.testing.assert_allclose(np.cos(2 * np.arctan2(rows[:, 6], rows[:, 7]) - poses[:, 2]), 1.0, atol=1e-9)


def test_tum_keeps_every_digit_of_a_stamp(log: ScanLog) -> None:
    stamps = np.array([1_700_000_000_123_456_789, -1, 999_999_999], dtype=np.int64)
    short = replace(
        log,
        ranges=log.ranges[:3],
        stamps_ns=stamps,
        trajectories={"a": replace(log.trajectory(), poses=log.trajectory().poses[:3])},
    )
    assert [line.split()[0] for line in tum_text(short).splitlines()] == [
        "1700000000.123456789",
        "-0.000000001",
        "0.999999999",
    ]


def test_poses_that_are_not_known_are_left_out(log: ScanLog) -> None:
    way = log.trajectory("true")
    known = np.arange(log.n_scans) % 3 != 0
    text = tum_text(replace(log, trajectories={"found": replace(way, is_known=known)}))
    assert text == tum_text(replace(log, trajectories={"true": way}).take(known))
    assert len(text.splitlines()) == np.count_nonzero(known)
