"""Beams of a scan used for localization, and their endpoints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.localization.parameters import LocalizationConfig
from mapper.sensors.scan import RangeScan


@dataclass(frozen=True, slots=True)
class ScanBeams:
    """The beams used; ``points`` (k, 2) are the endpoints, in the base's frame, of those with a measurement.

    ``beams`` (m, 2) are range, at most ``range_max``, and bearing in the base's frame of all used beams, including
    those without return; ``sensor`` (2,) is their origin in it. Metres and radians.
    """

    points: Float64Array
    beams: Float64Array
    sensor: Float64Array
    range_max: float


def limits_of(config: LocalizationConfig, range_min: float, range_max: float) -> tuple[float, float]:
    """Return the minimum and maximum range used, for a sensor with these limits, metres.

    Raises :class:`ConfigError` if the interval is empty.
    """
    low = range_min if config.laser_min_range < 0.0 else max(range_min, config.laser_min_range)
    high = range_max if config.laser_max_range < 0.0 else min(range_max, config.laser_max_range)
    if not low < high:
        raise ConfigError(
            "localization.ranges",
            f"No reading is used: the sensor measures {range_min:g} to {range_max:g} m, and laser_min_range and "
            f"laser_max_range leave {low:g} to {high:g} m.",
        )
    return low, high


def scan_beams(scan: RangeScan, mount: tuple[float, float, float], config: LocalizationConfig) -> ScanBeams:
    """Return about ``laser_max_beams`` beams of a scan by a sensor at ``mount``, ``T_base_laser``.

    Every n-th beam is used, as in AMCL; readings that are invalid or too short are ignored.
    """
    low, high = limits_of(config, scan.range_min, scan.range_max)
    n = len(scan.ranges)
    step = max(1, (n - 1) // max(1, int(config.laser_max_beams) - 1))
    ranges = scan.ranges[::step].astype(np.float64)
    bearings = scan.angles[::step] + mount[2]
    usable = ~np.isnan(ranges) & (ranges >= low)
    ranges, bearings = np.minimum(ranges[usable], high), bearings[usable]
    hits = ranges < high
    ends = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[hits] * ranges[hits, np.newaxis]
    sensor = np.array(mount[:2], dtype=np.float64)
    return ScanBeams(
        np.ascontiguousarray(ends + sensor), np.ascontiguousarray(np.column_stack([ranges, bearings])), sensor, high
    )
