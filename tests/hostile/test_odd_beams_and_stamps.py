"""Beams without an angle between them, stamps days apart and stamps with too few digits, in every format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, ReadError
from mapper.diagnosis import examine
from mapper.io.logs import open_log
from mapper.io.logs.summary import summarise
from mapper.sensors.scan import LaserScan
from tests.hostile.corpus import T0
from tests.hostile.test_times import EVEN, N, written
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND

FORMATS = ["carmen", "csv", "breezyslam", *recorded.KINDS]
ODD = [0.0, 1e-30, -1e-30, 50.0]
ROBOT_LASER = "ROBOTLASER1 0 -1 2 {step} 30 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 1.0 h 1.0\n"


@pytest.mark.parametrize("kind", FORMATS)
def test_stamps_30_years_apart_are_noted_with_their_scan(tmp_path: Path, kind: str) -> None:
    far = EVEN + np.where(np.arange(N) > 6, 10**9 * SECOND, 0)
    for name in ("far", "even"):
        (tmp_path / name).mkdir()
    notes = open_log(written(tmp_path / "far", kind, far)).notes
    assert any("Before scan 7 the time jumps by 1e+09 s (11574 days)" in note for note in notes), notes
    assert not any("jumps" in note for note in open_log(written(tmp_path / "even", kind, EVEN)).notes)


def test_stamps_of_sonars_30_years_apart_are_noted(tmp_path: Path) -> None:
    times = [1000 + 100 * i + (10**12 if i > 3 else 0) for i in range(8)]
    (tmp_path / "measurement.txt").write_text("".join(f"{t}{' 900' * 8}\n" for t in times))
    (tmp_path / "poses.txt").write_text("".join(f"{t} {i} 0 0\n" for i, t in enumerate(times)))
    notes = open_log(tmp_path).notes
    assert any("Before scan 4 the time jumps by 1e+09 s" in note for note in notes), notes


@pytest.mark.parametrize("step", ODD)
def test_beams_without_an_angle_between_them_are_refused(tmp_path: Path, step: float) -> None:
    path = tmp_path / "a.log"
    path.write_text(f"angle_min,0\nangle_increment,{step}\nrange_max,9\nstamp,x,y,theta,ranges\n0,0,0,0,1,2\n")
    with pytest.raises(ReadError, match=r"Line 5 has 2 ranges, which an angle_increment of .* rad cannot lie between"):
        open_log(path)
    path.write_text(ROBOT_LASER.format(step=step))
    with pytest.raises(ReadError, match=r"Line 1: this ROBOTLASER1 line states impossible angles"):
        open_log(path)
    with pytest.raises(ConfigError, match=r"angle_increment of a scan of 2 beams must be"):
        LaserScan(np.ones(2, dtype=np.float32), 0.0, step, 0.0, 9.0)
    LaserScan(np.ones(1, dtype=np.float32), 0.0, step, 0.0, 9.0)


@pytest.mark.parametrize("kind", recorded.KINDS)
@pytest.mark.parametrize("step", ODD)
def test_messages_whose_beams_have_no_angle_between_them_are_left_out(tmp_path: Path, kind: str, step: float) -> None:
    for name in ("some", "all"):
        (tmp_path / name).mkdir()
    good = [recorded.scan(T0 + i * SECOND, [1.0, 2.0]) for i in range(3)]
    odd = recorded.scan(T0 + 9 * SECOND, [1.0, 2.0], angles=(0.0, step))
    why = f"1 of 4 on /scan: the angle_increment is {np.float32(step):g} rad for 2 beams (message 4)"
    log = open_log(recorded.written(tmp_path / "some", [*good, odd], kind))
    assert log.n_scans == 3
    assert any(why in note for note in log.notes), log.notes
    with pytest.raises(ReadError, match="1 of 1 on /scan: the angle_increment is"):
        open_log(recorded.written(tmp_path / "all", [odd], kind))


def six_digits(folder: Path, start: float, step: float) -> Path:
    """A log as gmapping writes its corrected ones: C++ prints a double with six significant digits."""
    path = folder / "corrected.log"
    path.write_text(
        "".join(
            f"FLASER 4 2.0 2.1 3.0 2.5 {i / 10} 0 0 {i / 10} 0 0 {start + step * i:g} h {start + step * i:g}\n"
            for i in range(40)
        )
    )
    return path


def test_stamps_of_six_digits_are_no_times(tmp_path: Path) -> None:
    log = open_log(six_digits(tmp_path, 1042810000.0, 400.0))
    assert any("six significant digits, so they are whole multiples of 10000 s" in note for note in log.notes)
    summary = summarise(log)
    assert summary.time is not None
    assert (summary.duration_s, summary.time.rate_hz, summary.time.start_s) == (0.0, None, None)
    assert not [finding for finding in examine(log) if finding.check.startswith("clock.")]


def test_stamps_since_the_start_of_a_run_stay_times_with_six_digits(tmp_path: Path) -> None:
    log = open_log(six_digits(tmp_path, 2691.0, 0.25))
    assert not any("digits" in note for note in log.notes)
    assert summarise(log).duration_s == pytest.approx(39 * 0.25, abs=0.01)
