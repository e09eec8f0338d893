"""The sonar ring: its two files read independently, and the errors of bad files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.io.logs import is_log, open_log
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig, sensor_defaults

READINGS = "1000 5110 1000 2500 9999\n1200 500 600 700 800\n"
POSES = "1000 0 0 0\n1200 1000 -500 900\n"


def folder(tmp_path: Path, readings: str = READINGS, poses: str | None = POSES) -> Path:
    (tmp_path / "measurement.txt").write_text(readings)
    if poses is not None:
        (tmp_path / "poses.txt").write_text(poses)
    return tmp_path


@pytest.mark.parametrize("by", ["folder", "file"])
def test_two_files_are_one_log(tmp_path: Path, by: str) -> None:
    path = folder(tmp_path)
    log = open_log(path if by == "folder" else path / "measurement.txt")
    np.testing.assert_array_equal(log.ranges, np.array([[np.inf, 1, 2.5, np.inf], [0.5, 0.6, 0.7, 0.8]], np.float32))
    np.testing.assert_allclose(log.trajectory().poses, np.array([[0.0, 0.0, 0.0], [1.0, -0.5, np.pi / 2]]))
    assert log.stamps_ns.tolist() == [1_000_000_000, 1_200_000_000]
    np.testing.assert_allclose(np.degrees(log.angles), [-90, -30, 30, 90])
    assert np.degrees(log.beam_width) == pytest.approx(20.0)


def test_the_real_ring(data_file: Callable[[str], Path]) -> None:
    path = data_file("sonar/measurement.txt")
    log = open_log(path.parent)
    table = np.loadtxt(path)
    assert log.ranges.shape == (413, 8)
    assert np.count_nonzero(np.isinf(log.ranges)) == np.count_nonzero(table[:, 1:] >= 5110)
    assert (log.stamps_ns[-1] - log.stamps_ns[0]) / 1e9 == pytest.approx(92.837)
    np.testing.assert_allclose(np.degrees(log.angles), [-90, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90])


def test_the_bearings_assumed_fit_the_real_ring_best(data_file: Callable[[str], Path]) -> None:
    """The bearings of the sonars are not stated; among other rings, this one contradicts itself least."""
    log = open_log(data_file("sonar/measurement.txt"))
    config = MappingConfig().with_values(sensor_defaults(log.beam_width) | {"clamp": False, "range_max": 5.0})

    def contradiction(bearings: np.ndarray) -> float:
        from dataclasses import replace

        turned = replace(log, bearings=bearings)
        for_occupied, for_free = grid_for(turned, config), grid_for(turned, config)
        integrate_log(for_occupied, turned, config.with_values({"log_odds_miss": 0.0}))
        integrate_log(for_free, turned, config.with_values({"log_odds_hit": 0.0}))
        both = np.minimum(for_occupied.log_odds, -for_free.log_odds).sum()
        return float(both / (for_occupied.log_odds.sum() - for_free.log_odds.sum()))

    assumed = contradiction(log.angles)
    assert assumed < contradiction(-log.angles)
    assert assumed < 0.8 * contradiction(np.linspace(-np.pi, np.pi, 8, endpoint=False))
    assert assumed < 0.8 * contradiction(np.roll(log.angles, 2))


def test_a_sonar_log_calls_for_cones(tmp_path: Path) -> None:
    log = open_log(folder(tmp_path))
    defaults = sensor_defaults(log.beam_width)
    assert defaults["model"] == "sonar_cone"
    assert defaults["opening"] == pytest.approx(log.beam_width)
    assert "window" not in sensor_defaults(log.beam_width, {"model": "fixed_increments"})


@pytest.mark.parametrize(
    ("readings", "poses", "words"),
    [
        (READINGS, None, "next to measurement.txt there is no poses.txt"),
        (READINGS, POSES[:11], "2 rounds of readings and 1 poses"),
        (READINGS, POSES.replace("1200", "1201"), "the same times"),
        (READINGS + "1400 1 2 3\n", POSES, "Line 3 of measurement.txt has 4 numbers, not 5"),
        (READINGS, POSES + "1400 1 2\n", "Line 3 of poses.txt has 3 numbers, not 4"),
        (READINGS, POSES.replace("-500", "many"), "Line 2"),
        (READINGS, POSES.replace("-500", "1e300"), "out of range"),
        (READINGS.replace("600", "nan"), POSES, "not finite"),
    ],
)
def test_bad_files_are_refused_with_one_sentence(tmp_path: Path, readings: str, poses: str | None, words: str) -> None:
    path = folder(tmp_path, readings, poses) / "measurement.txt"
    with pytest.raises(MapperError) as refused:
        open_log(path)
    assert words in refused.value.message


def test_poses_alone_are_no_log(tmp_path: Path) -> None:
    assert not is_log(folder(tmp_path) / "poses.txt")
    with pytest.raises(MapperError, match=r"poses without readings, .* measurement\.txt and poses\.txt together"):
        open_log(tmp_path / "poses.txt")
    assert is_log(folder(tmp_path) / "measurement.txt")
