"""Clocks that run backwards, stop or jump by decades: a map is made, and the doctor names the scans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.diagnosis import examine
from mapper.io.logs import open_log
from mapper.io.logs.summary import summarise
from tests.hostile.corpus import T0
from tests.hostile.damage import check_usable
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND

N = 14
EVEN = np.arange(N, dtype=np.int64) * SECOND // 10
READINGS = [2.0, 2.1, 3.0, 2.5]

#: The stamps in nanoseconds, and what the doctor has to find.
CLOCKS = {
    "all backwards": (EVEN[::-1], "clock.backwards"),
    "once backwards": (np.where(np.arange(N) == 7, 0, EVEN), "clock.backwards"),
    "doubled": (np.repeat(EVEN[::2], 2), "clock.doubled"),
    "a jump of 30 years": (EVEN + np.where(np.arange(N) > 6, 10**9 * SECOND, 0), "clock.gap"),
    "standing still": (np.full(N, 5 * SECOND), None),
}


def written(folder: Path, kind: str, stamps: np.ndarray) -> Path:
    """A robot that drives straight on and always sees the same."""
    path = folder / "a.log"
    seconds = [f"{ns // SECOND}.{ns % SECOND:09d}" for ns in stamps.tolist()]
    readings = " ".join(map(str, READINGS))
    if kind == "carmen":
        path.write_text(
            "".join(
                f"ODOM {i / 10} 0 0 0 0 0 {t} h {t}\nFLASER 4 {readings} {i / 10} 0 0 {i / 10} 0 0 {t} h {t}\n"
                for i, t in enumerate(seconds)
            )
        )
    elif kind == "csv":
        rows = (f"{t},{i / 10},0,0,{readings.replace(' ', ',')}\n" for i, t in enumerate(seconds))
        path.write_text(
            "angle_min,-1\nangle_increment,0.5\nrange_max,9\nstamp,x,y,theta,ranges\n" + "".join(rows),
        )
    elif kind == "breezyslam":
        path.write_text(
            "".join(f"{ns // 1000} 0 {5 * i} {6 * i} {'1 ' * 20}900 2000 1500 1\n" for i, ns in enumerate(stamps))
        )
    else:
        said = [recorded.transform(T0, "base_link", "laser", 0.2, topic="/tf_static")]
        for i, ns in enumerate(stamps.tolist()):
            moved = recorded.transform(SECOND + ns, "odom", "base_link", i / 10)
            scan = recorded.scan(SECOND + ns, READINGS)
            # Recorded at an even pace, whatever the sensor's clock says.
            moved.stamp_ns = scan.stamp_ns = T0 + i
            said += [moved, scan]
        path = recorded.written(folder, said, kind)
    return path


@pytest.mark.parametrize("clock", CLOCKS)
@pytest.mark.parametrize("kind", ["carmen", "csv", "breezyslam", *recorded.KINDS])
def test_a_clock_that_no_clock_should_be(tmp_path, kind, clock):
    stamps, expected = CLOCKS[clock]
    log = open_log(written(tmp_path, kind, stamps))
    assert log.n_scans == N
    np.testing.assert_array_equal(np.diff(log.stamps_ns), np.diff(stamps))
    check_usable(log)
    assert summarise(log).duration_s == pytest.approx(float(np.ptp(stamps)) / SECOND)
    found = {finding.check for finding in examine(log) if finding.check.startswith("clock.")}
    assert expected in found if expected else not found


@pytest.mark.parametrize("kind", ["carmen", "csv", "breezyslam"])
def test_scans_that_are_30_years_apart_each(tmp_path, kind):
    """The ninth lies beyond what nanoseconds in 64 bits can hold: that line is named."""
    with pytest.raises(ReadError, match=r"Line (10|14|20): the time .* impossible") as caught:
        open_log(written(tmp_path, kind, np.arange(N, dtype=np.int64) * 10**9 * SECOND))
    assert caught.value.code == "log.stamp"
