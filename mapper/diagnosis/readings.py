"""Checks of the readings alone: a no return written as a range, and beams that hit the robot itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mapper.core.se2 import wrap_angle
from mapper.diagnosis.consistency import Examined, counts
from mapper.diagnosis.finding import Finding
from mapper.sensors.joint_log import is_measured, part_of_scan, sensors_of
from mapper.sensors.scan import ScanLog

FEW = "readings.few"
LEAST_MEASURED = 1000  #: ranges: with fewer, chance decides which of two maps is sharper
LEAST_SHARE = 0.003  #: of all measured readings: an exact value this frequent may be a code
BELOW = 20  #: number of values just below the maximum
OFTENER = 5.0  #: factor by which a code is more frequent than any of these; a real wall is measured at many distances
AT_LIMIT = 0.001  #: fraction of the stated range_max within which a value is at the limit
SELF_RANGE = 1.5  #: metres: parts of the robot are nearer
SELF_SPREAD = 0.02  #: metres
SELF_SHARE = 0.7  #: of a beam's readings
PASSED = 0.6  #: fraction of the beams reaching a part of the robot that pass it
MOVED = 2.0  #: metres of robot motion needed to distinguish the robot from a wall


def check(log: ScanLog, seen: Examined) -> list[Finding]:
    """Check the measured ranges."""
    return [*_few(log), *max_range_finding(log), *_of_itself(seen)]


def _few(log: ScanLog) -> list[Finding]:
    measured = int(np.count_nonzero(is_measured(log)))
    if measured >= LEAST_MEASURED:
        return []
    of, advice, known = "", "Choose the sensor that measures most, or record for longer.", log.trajectory().is_known
    if known is not None:
        of = f" of the {int(known.sum())} scans whose poses are known"
        advice = "Examine the log along other poses."
    return [
        Finding(
            FEW,
            f"Only {measured} readings{of} are measured ranges, and {LEAST_MEASURED} are needed to judge by the map "
            "they make whether mount, clocks and poses are right.",
            advice,
            1.0,
        )
    ]


def few_scans(n_scans: int) -> Finding:
    """Return the finding on a sensor with too few scans to be examined."""
    return Finding(FEW, f"Only {n_scans} scans: too few to judge.", "Record for longer.", 1.0)


def max_range_finding(log: ScanLog) -> list[Finding]:
    """Return the finding, if any, of readings that mean "no return" but are written as the maximum range."""
    measured = is_measured(log)
    if not measured.any():
        return []
    values = log.ranges[measured]
    greatest = float(values.max())
    exactly = values == np.float32(greatest)
    # Measured ranges are hardly ever equal to the last bit, and the maximum is the rarest.
    count = int(exactly.sum())
    if count < max(20, LEAST_SHARE * len(values)):
        return []
    # Rounded ranges repeat, as do those of a robot at rest, but then the values just below repeat as well.
    _, below = np.unique(values[~exactly & (values > 0.5 * greatest)], return_counts=True)
    if len(below) and count < OFTENER * int(below[-BELOW:].max()):
        return []
    # A log that marks no returns in another way has no code for them, unless the value is the sensor's limit.
    limits = np.array([part.range_max for part in sensors_of(log)])[part_of_scan(log)]
    stated = int(np.count_nonzero(np.isinf(log.ranges) | (log.ranges > limits[:, np.newaxis])))
    if stated >= count and greatest < (1.0 - AT_LIMIT) * log.range_max:
        return []
    scans = np.flatnonzero((log.ranges == np.float32(greatest)).any(axis=1))
    return [
        Finding(
            "readings.max_range",
            f"{100 * exactly.mean():.1f} % of the readings are exactly {greatest:.2f} m, the greatest there is: "
            "they say that nothing returned, and are taken for a wall.",
            "Set the max range a little lower; then they count as no return.",
            0.95,
            tuple(scans[:20].tolist()),
            {"range_max": float(np.floor(10.0 * greatest - 0.5) / 10.0)},
        )
    ]


def _of_itself(seen: Examined) -> list[Finding]:
    poses = seen.log.trajectory().poses
    if float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()) < MOVED:
        return []
    masked, bearings = _by_bearing(seen.log)
    enough = np.isfinite(masked).mean(axis=0) > SELF_SHARE
    if not enough.any():
        return []
    middle = np.full(len(bearings), np.nan)
    middle[enough] = np.nanmedian(masked[:, enough], axis=0)
    with np.errstate(invalid="ignore"):
        near = (np.abs(masked - middle) < SELF_SPREAD).mean(axis=0)
        itself = enough & (middle < SELF_RANGE) & (near > SELF_SHARE)
    beams = np.flatnonzero(itself)
    if len(beams):
        beams = beams[_passed(seen, bearings[beams], masked[:, beams]) > PASSED]
    if not len(beams):
        return []
    degrees = np.degrees(bearings[beams])
    return [
        Finding(
            "readings.itself",
            f"{len(beams)} beam{'s' if len(beams) > 1 else ''} around {np.median(degrees):.0f}° read "
            f"{np.median(middle[beams]):.2f} m wherever the robot is: they see the robot itself.",
            "Leave these beams out when recording, or the map gets a wall that moves with the robot.",
            0.95,
        )
    ]


def _passed(seen: Examined, bearings: NDArray[np.float64], ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the fraction of beams that passed the cells where some beams end, of all that reached them: 0 to 1, (n,).

    ``ranges`` (n_scans, n) are those of the beams at the ``bearings`` (n,); the result is the median over the scans.
    The robot drives through the positions where its own parts are seen. A wall along which it drives at a constant
    distance is also seen by other beams, and not passed. Of a cell and its neighbours the one passed least is used,
    because grazing beams pass cells of a wall.
    """
    grid = counts(seen)
    if grid.cell_statistics is None:
        return np.zeros(len(bearings))
    hits, misses = grid.cell_statistics.astype(np.float64)
    share = np.divide(misses, hits + misses, out=np.ones_like(hits), where=hits > 0.0)
    least = ndimage.minimum_filter(share, 3)
    poses = seen.log.sensor_poses()
    passed = np.zeros(len(bearings))
    for beam, (bearing, readings) in enumerate(zip(bearings, ranges.T, strict=True)):
        known = np.isfinite(readings)
        at = poses[known, 2] + bearing
        ends = poses[known, :2] + readings[known, np.newaxis] * np.stack([np.cos(at), np.sin(at)], axis=-1)
        cells = grid.geometry.world_to_cell(ends)
        cells = cells[grid.geometry.contains(cells)]
        if len(cells):
            passed[beam] = np.median(least[cells[:, 0], cells[:, 1]])
    return passed


def _by_bearing(log: ScanLog) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the measured ranges (n_scans, n_beams), NaN for all others, and the bearings of the beams, radians.

    For scans with different beams, the ranges are assigned to the nearest of the most common beams, at most one step
    away.
    """
    ranges = np.where(is_measured(log), log.ranges.astype(np.float64), np.nan)
    parts, owner = sensors_of(log), part_of_scan(log)
    usual = parts[int(np.argmax(np.bincount(owner, minlength=len(parts))))]
    angles = usual.angles
    if len(parts) == 1:
        return ranges, angles
    readings = np.full((log.n_scans, len(angles)), np.nan)
    for number, part in enumerate(parts):
        own = owner == number
        off = np.abs(wrap_angle(angles[:, np.newaxis] - part.angles))
        nearest = np.argmin(off, axis=1)
        step = max(abs(usual.angle_increment), abs(part.angle_increment))
        near = off[np.arange(len(angles)), nearest] <= step
        readings[np.ix_(own, near)] = ranges[np.ix_(own, nearest[near])]
    return readings, angles
