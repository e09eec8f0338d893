"""Named tuples that the compiled functions of scan matching take as arguments."""

from __future__ import annotations

from typing import NamedTuple

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array, UInt8Array

#: What is known of a beam's reading.
NO_POINT, POINT, POINT_WITH_NORMAL = 0, 1, 2

#: The weight of a residual e with the scale s, as an M-estimator has it (Zhang 1997).
SQUARES, HUBER, CAUCHY = 0, 1, 2


class ScanArrays(NamedTuple):
    """Scans as points in the frame of the robot's base, in the order of their bearing; each may be another sensor's.

    Beam b < ``n_beams``[i] of scan i sees in the direction ``first``[i] + b · ``step``[i] (``step`` > 0) from the
    sensor at ``sensor``[i]. Points of beams without a usable reading, and normals of points without one, are 0.
    """

    points: Float32Array  #: (n_scans, most beams of a sensor, 2), m
    normals: Float32Array  #: (n_scans, …, 2), of unit length, towards the sensor
    kind: UInt8Array  #: (n_scans, …): NO_POINT, POINT or POINT_WITH_NORMAL; NO_POINT from ``n_beams``[i] on
    n_beams: Int64Array  #: (n_scans,)
    first: Float64Array  #: (n_scans,), rad
    step: Float64Array  #: (n_scans,), rad
    wraps: BoolArray  #: (n_scans,): whether the beam after the last is the first: the sensor sees the whole circle
    sensor: Float64Array  #: (n_scans, 2), m


#: The residual of a pair: its distance across the line of the other scan, or the vector from point to point.
LINE, POINTS = 0, 1


class PairRule(NamedTuple):
    """Rule by which points of two scans correspond, and the weight of a pair."""

    min_cosine: float  #: between the two normals; −1 takes all pairs, also of points without a normal
    max_beams: int  #: by how many beams, either way, a corresponding beam may be off; all of them: the nearest point
    weight: int  #: SQUARES, HUBER or CAUCHY
    scale: float  #: m, of the weight
    stride: int  #: take each stride-th beam of the moving scan
    keep: float = 1.0  #: the share of the pairs that counts, those with the smallest residuals
    residual: int = 0  #: LINE or POINTS


class Iterations(NamedTuple):
    """The Gauss–Newton iterations, in each of which the gate shrinks by ``shrink`` down to ``last_gate``."""

    most: int
    first_gate: float  #: m: points farther apart do not correspond
    last_gate: float  #: m
    shrink: float
    stop_m: float  #: a step shorter than this, and turning by less than stop_rad, with the last gate, is the last one
    stop_rad: float
