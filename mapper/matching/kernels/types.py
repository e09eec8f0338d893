"""Named tuples that the compiled functions of scan matching take as arguments."""

from __future__ import annotations

from typing import NamedTuple

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array, UInt8Array

#: Kinds of readings of a beam.
NO_POINT, POINT, POINT_WITH_NORMAL = 0, 1, 2

#: Weight of a residual e with the scale s, as in M-estimators (Zhang 1997).
SQUARES, HUBER, CAUCHY = 0, 1, 2


class ScanArrays(NamedTuple):
    """Scans as points in the robot's base frame, in the order of their bearing; their sensors may differ.

    Beam b < ``n_beams``[i] of scan i points in the direction ``first``[i] + b · ``step``[i] (``step`` > 0) from the
    sensor at ``sensor``[i]. Points of beams without a usable reading, and missing normals, are 0.
    """

    points: Float32Array  #: (n_scans, most beams of a sensor, 2), m
    normals: Float32Array  #: (n_scans, …, 2), of unit length, towards the sensor
    kind: UInt8Array  #: (n_scans, …): NO_POINT, POINT or POINT_WITH_NORMAL; NO_POINT from ``n_beams``[i] on
    n_beams: Int64Array  #: (n_scans,)
    first: Float64Array  #: (n_scans,), rad
    step: Float64Array  #: (n_scans,), rad
    wraps: BoolArray  #: (n_scans,): whether the first beam follows the last: the sensor has a field of view of 360°
    sensor: Float64Array  #: (n_scans, 2), m


#: The residual of a pair: its distance from the line of the other scan, or the vector between the points.
LINE, POINTS = 0, 1


class PairRule(NamedTuple):
    """Rule by which points of two scans are paired, and the weight of a pair."""

    min_cosine: float  #: between the two normals; −1 accepts all pairs, also of points without a normal
    max_beams: int  #: maximum offset, in beams, of a corresponding beam; all beams: the nearest point
    weight: int  #: SQUARES, HUBER or CAUCHY
    scale: float  #: m, of the weight
    stride: int  #: use every stride-th beam of the moving scan
    keep: float = 1.0  #: the fraction of the pairs that counts, those with the smallest residuals
    residual: int = 0  #: LINE or POINTS


class Iterations(NamedTuple):
    """The Gauss–Newton iterations, in each of which the gate shrinks by ``shrink`` down to ``last_gate``."""

    most: int
    first_gate: float  #: m: points farther apart do not correspond
    last_gate: float  #: m
    shrink: float
    stop_m: float  #: stop if a step is shorter than this and rotates by less than stop_rad, at the last gate
    stop_rad: float
