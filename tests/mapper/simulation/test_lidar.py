"""The lidar: its parameters, its noise, its limits."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.simulation import SENSOR_PARAMETERS, WORLDS, SensorConfig
from mapper.simulation.lidar import RANGE_MIN, TURN, measure, true_ranges

HALL = WORLDS["hall"]


def test_each_row_of_the_table_is_refused_beyond_its_bounds_and_named():
    for row in SENSOR_PARAMETERS:
        assert row.group == "sensor"
        if row.kind == "choice":
            assert row.initial in row.choices
            continue
        assert row.low <= float(row.initial) <= row.high
        assert getattr(SensorConfig().with_values({row.name: row.low}), row.name) == row.low
        assert getattr(SensorConfig().with_values({row.name: row.high}), row.name) == row.high
        for bad in (row.low - 1e-3, row.high + 1e-3, np.nan, np.inf, "10", None, True):
            with pytest.raises(ConfigError) as caught:
                SensorConfig().with_values({row.name: bad})
            assert caught.value.code == f"parameter.{row.name}"
    with pytest.raises(ConfigError, match="whole"):
        SensorConfig(n_beams=100.5)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="no sensor parameter 'beams'"):
        SensorConfig().with_values({"beams": 3})


def test_a_full_turn_has_no_beam_twice_and_a_fan_has_both_edges():
    full = SensorConfig(n_beams=360)
    assert full.angle_increment == pytest.approx(TURN / 360)
    assert full.angle_min == pytest.approx(-np.pi)
    fan = SensorConfig(n_beams=181, field_of_view=np.pi)
    scan = measure(HALL, fan, HALL.start, np.random.default_rng(0))
    np.testing.assert_allclose(scan.angles[[0, 90, 180]], [-np.pi / 2, 0.0, np.pi / 2], atol=1e-12)


def test_the_noise_has_the_configured_standard_deviation():
    sensor = SensorConfig(n_beams=1080, range_max=30.0, range_noise=0.05)
    rng = np.random.default_rng(2)
    truth = true_ranges(HALL, sensor, HALL.start)
    errors = np.concatenate([measure(HALL, sensor, HALL.start, rng).ranges - truth for _ in range(20)])
    assert errors.std() == pytest.approx(0.05, rel=0.03)
    assert abs(errors.mean()) < 0.002
    exact = measure(HALL, sensor.with_values({"range_noise": 0.0}), HALL.start, rng)
    np.testing.assert_allclose(exact.ranges, truth, rtol=1e-6)


def test_no_reading_is_negative_and_none_is_beyond_the_range():
    sensor = SensorConfig(range_noise=0.5, range_max=3.1)
    rng = np.random.default_rng(4)
    corner = WORLDS["maze"].nearest_free((0.2, 0.2), 0.05)
    seen = np.concatenate([measure(WORLDS["maze"], sensor, (*corner, 0.3), rng).ranges for _ in range(50)])
    assert np.all(seen >= np.float32(RANGE_MIN))
    assert not np.isnan(seen).any()
    assert np.all(np.isinf(seen) | (seen <= sensor.range_max))
    assert np.isinf(seen).any()
    assert np.isclose(seen, RANGE_MIN).any()


def test_a_scan_has_the_properties_of_its_sensor():
    sensor = SensorConfig(n_beams=90, range_max=7.5)
    scan = measure(HALL, sensor, HALL.start, np.random.default_rng(0), 123)
    assert (len(scan.ranges), scan.range_max, scan.stamp_ns) == (90, 7.5, 123)
    assert (scan.angle_min, scan.angle_increment) == (sensor.angle_min, sensor.angle_increment)
