"""Rules by which SLAM aligns scans: correspondences and information."""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.matching.kernels.types import CAUCHY, Iterations, PairRule
from mapper.slam.kernels.information import write_information

NOISE = 0.03  #: metres: of a point relative to the wall of another scan
CORRELATION = 0.05  #: fraction of a scan's points that are independent evidence; errors of neighbours are correlated
MIN_COSINE = 0.75  #: of two normals, 41° apart: different sides of a corner are not paired
WIDEST_SEARCH = math.radians(12.0)  #: to either side, for a corresponding beam
FALSE_SHARE = 0.03  #: sin² 10°: normals that are off by 10° make a wall constrain motion along itself by this fraction
FLOOR = np.array([0.01, 0.01, 0.005])  #: metres, metres, radians: minimum standard deviations of an alignment
FRONT_ITERATIONS = Iterations(6, 0.35, 0.12, 0.5, 1e-3, 5e-4)
LOOP_ITERATIONS = Iterations(8, 0.4, 0.12, 0.6, 1e-3, 5e-4)
LEAST_PAIRS = 40  #: pairs of points for an alignment to count


def pair_rule(least_step: float) -> PairRule:
    """Return the rule for corresponding points of two scans, for the smallest angle between beams, radians."""
    return PairRule(MIN_COSINE, int(WIDEST_SEARCH / least_step) + 1, CAUCHY, NOISE, 1)


def information_of(hessian: Float64Array, heading: float, prior: Float64Array) -> Float64Array:
    """Return the information (3, 3) of an aligned pose in its own frame, from the pairs' sums in the map frame.

    ``hessian`` (3, 3) is Σ w JᵀJ of point-to-line pairs over x, y and theta, with the weights ``prior`` (3,) of a prior
    on its diagonal; ``heading`` is the pose's, radians. Normals that are off by a few degrees make a wall constrain
    motion along itself, so :data:`FALSE_SHARE` of the strongest direction's information is subtracted from every
    direction.
    """
    information = np.empty((3, 3))
    write_information(hessian, prior, heading, FALSE_SHARE, CORRELATION / NOISE**2, FLOOR, information)
    return information
