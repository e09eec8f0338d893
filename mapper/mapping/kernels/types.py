"""Named tuples that the compiled updates take as arguments.

numba passes the fields of a named tuple as separate arguments, so they cost nothing in a kernel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array


class ReadingFilter(NamedTuple):
    """Filter of readings, and the width of their hit window: ``window`` + ``growth`` · z at a reading z."""

    range_min: float  #: m; shorter readings are ignored
    range_max: float  #: m; longer readings are no return
    window: float  #: m, the width at z = 0
    growth: float  #: m/m, the additional width for each metre of range
    no_return_free: bool  #: whether no return makes all cells up to ``range_max`` free


class LogOddsUpdate(NamedTuple):
    """ℓ ← min(max(ℓ + increment, low), high) in float32, where the increment is ``miss`` or ``hit``, log-odds."""

    miss: np.float32
    hit: np.float32
    low: np.float32
    high: np.float32


class Evidence(NamedTuple):
    """The increments in float64, not rounded, log-odds; for models whose evidence varies between cells."""

    miss: float
    hit: float


class Cone(NamedTuple):
    """Distribution of evidence over the field of one beam."""

    profile: int  #: FLAT, GAUSSIAN or RAMP of :mod:`mapper.mapping.kernels.cones`
    opening: float  #: rad, from edge to edge
    mark_endpoints: bool  #: whether the cells that hold endpoints always get the hit increment


class Scans(NamedTuple):
    """Scans of one sensor on the lattice of a grid."""

    ranges: Float32Array  #: (n_scans, n_beams), m
    sensors: Float64Array  #: (n_scans, 4): x, y (m), cos θ, sin θ of ``T_map_laser``
    beams: Float64Array  #: (n_beams, 2): cosine and sine of the bearings
    fields: Float64Array  #: (n_beams, 4): cosine and sine of each field's right edge, then of its left edge
    headings: Float64Array  #: (n_scans, 2): cosine and sine of the sensor's heading along the lattice
    numbers: Int64Array  #: (n_scans,): equal for consecutive rows that are beams of one scan


class Cells(NamedTuple):
    """The cells of a grid as flat arrays, row by row."""

    log_odds: Float32Array  #: (rows · cols,)
    observed: BoolArray  #: (rows · cols,)
    cols: int
