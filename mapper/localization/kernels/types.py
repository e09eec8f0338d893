"""Named tuples that the compiled functions of localization take as arguments."""

from __future__ import annotations

from typing import NamedTuple

from mapper.core.array_types import BoolArray, UInt16Array
from mapper.grid.kernels.lattice import Frame


class ScoreField(NamedTuple):
    """A likelihood field: the score that an endpoint in each cell adds to a pose.

    ``scores`` (rows, cols) uint16 are in the units of :class:`mapper.localization.likelihood_field.LikelihoodField`; an
    endpoint outside the grid scores 0.
    """

    scores: UInt16Array
    frame: Frame


class OccupiedCells(NamedTuple):
    """The occupied cells (rows, cols), in which beams end, and their frame in the map."""

    occupied: BoolArray
    frame: Frame


class Motion(NamedTuple):
    """An odometry motion: turn, drive, turn, and the standard deviations of their errors.

    ``omni`` is 1 for a robot that also moves sideways: ``turn_1`` is then the direction of motion, without an error;
    ``sigma_1`` is that of the sideways error, metres.
    """

    turn_1: float  #: rad
    distance: float  #: m
    turn_2: float  #: rad
    sigma_1: float  #: rad; for ``omni`` m
    sigma_distance: float  #: m
    sigma_2: float  #: rad
    omni: int


class Mixture(NamedTuple):
    """The four components of the beam model, and the range limits."""

    z_hit: float
    z_short: float
    z_max: float
    z_rand: float
    sigma_hit: float  #: m
    lambda_short: float  #: 1/m
    range_max: float  #: m


class Bins(NamedTuple):
    """Sizes of the pose bins used for KLD sampling and clustering."""

    side: float  #: m
    turn: float  #: rad
