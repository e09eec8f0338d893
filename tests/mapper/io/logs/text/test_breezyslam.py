"""BreezySLAM's logs: the columns of a real log read independently, and wheel arcs against small steps."""

from __future__ import annotations

import gzip
import math

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.io.logs import is_log, open_log
from mapper.io.logs.text.breezyslam import ANGLE_MIN, STEP, wheel_poses


def line(micros: int, left: int, right: int, distances: list[int]) -> str:
    return " ".join(map(str, [micros, 0, left, right, *[7.5] * 20, *distances, 0])) + "\n"


def test_a_line(tmp_path):
    path = tmp_path / "a"
    path.write_text(line(1_500_000, 10, 20, [0, 19, 20, 1234, 5599, 5600]) + line(2_000_000, 10, 20, [100] * 6))
    assert is_log(path)
    log = open_log(path)
    np.testing.assert_array_equal(
        log.ranges[0], np.array([np.nan, np.nan, 0.02, 1.234, 5.599, np.inf], dtype=np.float32)
    )
    assert log.stamps_ns.tolist() == [1_500_000_000, 2_000_000_000]
    assert log.mount == (0.145, 0.0, 0.0)
    assert not log.trajectory("wheel").poses.any()


def test_the_wheels_arcs_are_the_limit_of_small_straight_steps():
    rng = np.random.default_rng(3)
    ticks = np.cumsum(rng.integers(-300, 900, (30, 2)), axis=0).astype(np.float64)
    x = y = theta = 0.0
    expected = [(x, y, theta)]
    for step in np.diff(ticks, axis=0):
        left, right = step * 2 * math.pi * 0.077 / 2000 / 1000
        for _ in range(1000):
            x += (left + right) / 2 * math.cos(theta)
            y += (left + right) / 2 * math.sin(theta)
            theta += (right - left) / 0.330
        expected.append((x, y, theta))
    poses = wheel_poses(ticks)
    np.testing.assert_allclose(poses[:, :2], np.array(expected)[:, :2], atol=1e-3)
    np.testing.assert_allclose(np.cos(poses[:, 2]), np.cos(np.array(expected)[:, 2]), atol=1e-9)


def test_a_turn_on_the_spot_and_a_straight_run():
    turn = 2000 * 0.330 / (2 * 0.077)  # ticks of each wheel, in opposite ways, for a whole turn
    poses = wheel_poses(np.array([[0.0, 0.0], [-turn / 4, turn / 4], [2000 - turn / 4, 2000 + turn / 4]]))
    np.testing.assert_allclose(poses[1], [0.0, 0.0, math.pi / 2], atol=1e-9)
    np.testing.assert_allclose(poses[2], [0.0, 2 * math.pi * 0.077, math.pi / 2], atol=1e-9)


def test_the_real_log(data_file):
    path = data_file("breezyslam/exp1.dat.gz")
    rows = [row.split() for row in gzip.decompress(path.read_bytes()).splitlines()]
    columns = np.array([[int(value) for value in row[24:706]] for row in rows])
    log = open_log(path)
    assert (log.n_scans, log.n_beams) == (756, 682)
    np.testing.assert_allclose(log.ranges, np.where(columns < 20, np.nan, columns / 1000.0), rtol=1e-6)
    assert math.degrees(-ANGLE_MIN - (ANGLE_MIN + 681 * STEP)) == pytest.approx(-0.35, abs=0.2)
    assert (log.stamps_ns[-1] - log.stamps_ns[0]) / 1e9 == pytest.approx(74.6, abs=0.1)
    steps = np.hypot(*np.diff(log.trajectory("wheel").poses[:, :2], axis=0).T)
    ticks = np.array([[int(row[2]), int(row[3])] for row in rows])
    turns = np.abs(np.diff(ticks.mean(axis=1))).sum() / 2000
    assert steps.sum() == pytest.approx(turns * 2 * math.pi * 0.077, rel=0.01)
    assert steps.max() < 0.3


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (line(1, 2, 3, [1, 2, 3]) + "1 2 3\n" + line(1, 2, 3, [1, 2, 3]), "log.truncated_line", "Line 2 ends early"),
        (line(1, 2, 3, [1, 2, 3]) + line(1, 2, 3, [1, 2]), "log.beams_vary", "Line 2"),
        (line(1, 2, 3, [1, 2, 3]) + line(1, 2, 3, [1, 2, 3]).replace(" 2 3 ", " 2e99 3 ", 1), "log.ticks", "Line 2"),
        (line(1, 2, 3, [1, 2, 3]) + line(1, 2, 3, [1, 2, 3]).replace(" 2 3 ", " nan 3 ", 1), "log.ticks", "Line 2"),
        (line(1, 2, 3, [1, 2, 3]) + "9" * 40 + line(1, 2, 3, [1, 2, 3]), "log.stamp", "Line 2"),
        (line(1, 2, 3, [1, 2, 3]) + line(1, 9 * 10**11, 9 * 10**11, [1, 2, 3]), "log.extent", "more than"),
    ],
)
def test_bad_lines(tmp_path, text, code, words):
    path = tmp_path / "a.dat"
    path.write_text(text)
    with pytest.raises(MapperError, match=words) as caught:
        open_log(path)
    assert caught.value.code == code
