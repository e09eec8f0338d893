"""The summary of a log against the definition of its figures, on made-up logs and on a real one."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.io.logs import open_log
from mapper.io.logs.summary import ReadingCounts, recorded_seconds, summarise
from mapper.sensors.scan import ScanLog, Trajectory


def log_at(stamps_ns: list[int]) -> ScanLog:
    n = len(stamps_ns)
    ranges = np.tile(np.array([1.0, np.inf, np.nan, 2.0, -np.inf], dtype=np.float32), (n, 1))
    poses = np.stack([3.0 * np.arange(n), 4.0 * np.arange(n), np.zeros(n)], axis=-1)
    return ScanLog(ranges, -1.0, 0.5, 0.1, 30.0, np.array(stamps_ns, dtype=np.int64), {"scan": Trajectory(poses)})


def test_figures() -> None:
    facts = summarise(log_at([5_000_000_000, 7_000_000_000, 6_000_000_000, 6_500_000_000]))
    assert (facts.scans, facts.beams, facts.duration_s) == (4, 5, 2.0)
    assert facts.readings == ReadingCounts(measured=8, no_return=4, invalid=8)
    assert facts.field_of_view_deg == pytest.approx(np.degrees(2.0))
    assert [(one.name, one.length_m) for one in facts.trajectories] == [("scan", 15.0)]


def test_when_the_scans_were_made() -> None:
    tenth = 100_000_000
    start = 1_405_931_000 * 10 * tenth
    steps = np.cumsum([0, 1, 1, 1, 30, 1, 1, 12, 1, -3, 5]) * tenth
    time = summarise(log_at((start + steps).tolist())).time
    assert time is not None
    assert time.start_s == pytest.approx(1_405_931_000)
    assert time.rate_hz == pytest.approx(10.0)
    assert time.gaps == 2
    assert time.longest_gap_s == pytest.approx(3.0)
    assert time.longest_gap_at_s == pytest.approx(0.3)
    none = summarise(log_at([7, 7, 7])).time
    assert none is not None
    assert (none.start_s, none.rate_hz, none.gaps) == (None, None, 0)


def test_a_log_without_scans_lasts_no_time() -> None:
    assert summarise(log_at([])).duration_s == 0.0


@given(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=1, max_size=20))
def test_recorded_time_never_decreases_and_ends_with_the_duration(stamps: list[int]) -> None:
    seconds = recorded_seconds(log_at(stamps))
    assert seconds.shape == (len(stamps),)
    # By definition, in whole numbers that do not overflow.
    expected = [(max(stamps[: i + 1]) - min(stamps)) / 1e9 for i in range(len(stamps))]
    np.testing.assert_allclose(seconds, expected, rtol=1e-12)
    assert seconds[-1] == pytest.approx((max(stamps) - min(stamps)) / 1e9)


def test_intel_lasts_44_minutes(data_file: Callable[[str], Path]) -> None:
    path = data_file("carmen/intel.log.gz")
    lines = gzip.decompress(path.read_bytes()).splitlines()
    stamps = [float(line.split()[188]) for line in lines if line.startswith(b"FLASER")]
    log = open_log(path)
    assert summarise(log).duration_s == pytest.approx(max(stamps) - min(stamps), abs=1e-4)
    assert 44 * 60 < summarise(log).duration_s < 45 * 60
    assert (np.diff(log.stamps_ns) < 0).any(), "its clock runs backwards now and then"
    assert (np.diff(recorded_seconds(log)) >= 0).all()
