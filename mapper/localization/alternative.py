"""A second hypothesis of where the robot is, and the test that decides between it and the filter's own.

Sources: Wald 1945, Sequential tests of statistical hypotheses (the ratio and its limits); the ratio of two filters'
predictive likelihoods, as between the tracks of multiple hypothesis tracking (Jensfelt and Kristensen 2001, Active
global localization for a mobile robot using multiple hypothesis tracking).
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import wrap_angle
from mapper.localization.estimate import CONVERGED_M, CONVERGED_RAD, LOST_TIMES, Estimate
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.scan_beams import ScanBeams

ERROR = 1e-3  #: wanted probability that the test decides wrongly, either way
LIMIT = math.log((1.0 - ERROR) / ERROR)  #: of the logarithm of the likelihoods' ratio: Wald's log A and −log B
MOST_SCANS = 64  #: after which a test without a decision ends in favour of the filter
SEARCHED = 0.2  #: an alternative's particles at first, of ``global_particles``
SHARE = 0.5  #: weight that an alternative's particles get in the filter once the test has decided for them


class Filter(Protocol):
    """Interface of a particle filter that an alternative uses (:class:`mapper.localization.MonteCarloLocalizer`)."""

    estimate: Estimate
    log_evidence: float
    particles: Float64Array
    weights: Float64Array

    def predict(self, before: Float64Array, after: Float64Array) -> None:
        """Move the particles."""

    def correct(self, scan: ScanBeams) -> None:
        """Weigh the particles by a scan."""


class Alternative:
    """A filter on poses apart from another filter's, and the sequential probability ratio test of the two.

    ``log_ratio`` is Σ log p(z | alternative) − log p(z | filter) over the scans after the one that the alternative was
    drawn from: that one was chosen because it fits.
    """

    def __init__(self, robot: Filter) -> None:
        self.robot = robot
        self.log_ratio = 0.0
        self.n_scans = 0

    def correct(self, scan: ScanBeams, log_evidence: float) -> None:
        """Weigh the alternative by a scan that was as likely as ``log_evidence`` in the filter."""
        self.robot.correct(scan)
        self.log_ratio += self.robot.log_evidence - log_evidence
        self.n_scans += 1

    @property
    def has_won(self) -> bool:
        """Whether the scans are so much likelier at the alternative's poses that the test decides for them."""
        return self.log_ratio >= LIMIT

    def has_lost(self, estimate: Estimate) -> bool:
        """Whether the test decides for the filter, has taken too long, or the alternative is where the filter is."""
        own = self.robot.estimate
        is_same = own.share >= SHARE and bool(near(own.pose[np.newaxis], estimate.pose)[0])
        return is_same or self.log_ratio <= -LIMIT or self.n_scans >= MOST_SCANS


def alternative_config(config: LocalizationConfig) -> LocalizationConfig:
    """Return the parameters of an alternative: no particles are added to recover it, and none stands against it."""
    return config.with_values(
        {
            "reset_below": 0.0, "recovery_alpha_slow": 0.0, "recovery_alpha_fast": 0.0,
            "global_particles": alternative_particles(config),
        }
    )  # fmt: skip


def alternative_particles(config: LocalizationConfig) -> int:
    """Return how many particles an alternative has at first, and at most until it has converged."""
    return max(100, round(SEARCHED * config.global_particles))


def near(poses: Float64Array, pose: Float64Array) -> NDArray[np.bool_]:
    """Return which of ``poses`` (n, 3) may be the place of a converged filter at ``pose`` (3,)."""
    off = poses - pose
    is_close = np.hypot(off[:, 0], off[:, 1]) <= LOST_TIMES * CONVERGED_M
    return is_close & (np.abs(wrap_angle(off[:, 2])) <= LOST_TIMES * CONVERGED_RAD)
