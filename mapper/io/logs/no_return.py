"""Detection of a distance that means "no return", in logs that state no such limit, because no wall can look like
it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.sensors.scan import ScanLog

LEAST_READINGS = 20  #: of the maximum distance, in wide runs of beams, and of all others
LEAST_SCANS = 5  #: with such runs
LEAST_RUN_RAD = np.radians(30.0)  #: of neighbouring beams that all read the same distance
WIDER = 2.0  #: times the width at which a flat wall has one distance
APART_M = 0.5  #: between two positions with such runs
LEAST_STEP_M = 1e-3  #: distances that differ by less are in one quantisation step, with 32-bit errors
ENOUGH = 100_000  #: readings used to estimate the step


def code_for_no_return(log: ScanLog) -> float | None:
    """Return the maximum distance of a log, metres, if it means no return; None if it may be a wall.

    Beams that hit a flat wall read one distance d only as long as rounding hides the increase to the sides: with a
    quantisation step q over an angle of √(8 q / d). If many neighbouring beams read the maximum distance over twice
    that angle, and at least 30°, in 5 scans and from positions 0.5 m apart, the wall would be an arc around the sensor
    that moves with it. Sonars, whose cones read the nearest wall, are not tested.
    """
    if log.beam_width > 0.0 or log.bearings is not None or log.n_beams < 2:
        return None
    readings = log.ranges
    counts = (readings >= log.range_min) & (readings <= log.range_max) & (readings > 0.0) & np.isfinite(readings)
    if not counts.any():
        return None
    greatest = float(readings[counts].max())
    if np.count_nonzero(counts & (readings < np.float32(greatest))) < LEAST_READINGS:
        return None
    rows = np.flatnonzero((counts & (readings == np.float32(greatest))).any(axis=1))
    scans, widths, beams = _runs(readings[rows] == np.float32(greatest), abs(log.angle_increment))
    flat = np.sqrt(8.0 * _step(readings[counts]) / greatest)
    wide = widths >= max(LEAST_RUN_RAD, WIDER * flat)
    if beams[wide].sum() < LEAST_READINGS:
        return None
    seen_in = np.unique(rows[scans[wide]])
    places = log.trajectory().poses[seen_in, :2]
    return greatest if len(seen_in) >= LEAST_SCANS and float(np.ptp(places, axis=0).max()) >= APART_M else None


def without_code(log: ScanLog, code: float) -> ScanLog:
    """Return the log with the readings equal to the code replaced by +inf, no return."""
    return replace(log, ranges=np.where(log.ranges == np.float32(code), np.float32(np.inf), log.ranges))


def _step(readings: NDArray[np.float32]) -> float:
    """Return the usual difference between consecutive distinct distances, metres."""
    steps = np.diff(np.unique(readings[:: 1 + len(readings) // ENOUGH]).astype(np.float64))
    steps = steps[steps >= LEAST_STEP_M]
    return float(np.quantile(steps, 0.1)) if len(steps) else 0.0


def _runs(is_same: NDArray[np.bool_], increment: float) -> tuple[Int64Array, NDArray[np.float64], Int64Array]:
    """Return the runs of neighbouring beams in (n_scans, n_beams): their scans, angles in radians and beams, (n,)."""
    edges = np.diff(np.pad(is_same, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    scans, first = np.nonzero(edges == 1)
    beams = (np.nonzero(edges == -1)[1] - first).astype(np.int64)
    return scans.astype(np.int64), np.asarray((beams - 1) * increment, dtype=np.float64), beams
