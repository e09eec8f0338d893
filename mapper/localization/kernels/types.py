"""Named tuples that the compiled functions of localization take as arguments."""

from __future__ import annotations

from typing import NamedTuple

from mapper.core.array_types import BoolArray, UInt16Array
from mapper.grid.kernels.lattice import Frame


class ScoreField(NamedTuple):
    """A likelihood field: what an end point in each cell adds to the score of a pose.

    ``scores`` (rows, cols) uint16 are in units that :class:`mapper.localization.likelihood_field.LikelihoodField`
    knows; that of an end point outside the grid is 0.
    """

    scores: UInt16Array
    frame: Frame


class OccupiedCells(NamedTuple):
    """The cells (rows, cols) in which a beam ends, and where they lie in the map."""

    occupied: BoolArray
    frame: Frame


class Motion(NamedTuple):
    """A motion by odometry: turn, drive, turn, and the standard deviations of their errors.

    ``omni`` is 1 for a robot that moves sideways too: ``turn_1`` is then the direction in which it moves, without an
    error of its own; ``sigma_1`` is that of the sideways error, metres.
    """

    turn_1: float  #: rad
    distance: float  #: m
    turn_2: float  #: rad
    sigma_1: float  #: rad; for ``omni`` m
    sigma_distance: float  #: m
    sigma_2: float  #: rad
    omni: int


class Mixture(NamedTuple):
    """The four parts of the beam model, and the ranges that are measured."""

    z_hit: float
    z_short: float
    z_max: float
    z_rand: float
    sigma_hit: float  #: m
    lambda_short: float  #: 1/m
    range_max: float  #: m


class Bins(NamedTuple):
    """Sides of the bins of poses that KLD sampling counts and clusters are made of."""

    side: float  #: m
    turn: float  #: rad
