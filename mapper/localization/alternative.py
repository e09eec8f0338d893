"""A second hypothesis of the robot's pose, and the test between it and the filter's hypothesis.

Sources: Wald 1945, Sequential tests of statistical hypotheses (the ratio and its limits); the ratio of the predictive
likelihoods of two filters, as between the tracks of multiple hypothesis tracking (Jensfelt and Kristensen 2001, Active
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

ERROR = 1e-3  #: probability of a wrong decision, either way
LIMIT = math.log((1.0 - ERROR) / ERROR)  #: limit of the log-likelihood ratio: Wald's log A and −log B
MOST_SCANS = 64  #: after which an undecided test ends in favour of the filter
SEARCHED = 0.2  #: initial number of an alternative's particles, as a fraction of ``global_particles``
SHARE = 0.5  #: weight of an alternative's particles in the filter after the test has decided for them


class Filter(Protocol):
    """Interface of a particle filter used by an alternative (:class:`mapper.localization.MonteCarloLocalizer`)."""

    estimate: Estimate
    log_evidence: float
    particles: Float64Array
    weights: Float64Array

    def predict(self, before: Float64Array, after: Float64Array) -> None:
        """Move the particles."""

    def correct(self, scan: ScanBeams) -> None:
        """Weight the particles by a scan."""


class Alternative:
    """A filter on poses apart from another filter's, and the sequential probability ratio test between the two.

    ``log_ratio`` is Σ log p(z | alternative) − log p(z | filter) over the scans after the one from which the
    alternative was drawn; that scan is excluded because it was selected for its fit.
    """

    def __init__(self, robot: Filter) -> None:
        self.robot = robot
        self.log_ratio = 0.0
        self.n_scans = 0

    def correct(self, scan: ScanBeams, log_evidence: float) -> None:
        """Weight the alternative by a scan with the log-likelihood ``log_evidence`` in the filter."""
        self.robot.correct(scan)
        self.log_ratio += self.robot.log_evidence - log_evidence
        self.n_scans += 1

    @property
    def has_won(self) -> bool:
        """Whether the test decides for the alternative."""
        return self.log_ratio >= LIMIT

    def has_lost(self, estimate: Estimate) -> bool:
        """Whether the test decides for the filter or has taken too long, or the alternative coincides with the
        filter.
        """
        own = self.robot.estimate
        is_same = own.share >= SHARE and bool(near(own.pose[np.newaxis], estimate.pose)[0])
        return is_same or self.log_ratio <= -LIMIT or self.n_scans >= MOST_SCANS


def alternative_config(config: LocalizationConfig) -> LocalizationConfig:
    """Return the parameters of an alternative: without recovery and without an alternative of its own."""
    return config.with_values(
        {
            "reset_below": 0.0, "recovery_alpha_slow": 0.0, "recovery_alpha_fast": 0.0,
            "global_particles": alternative_particles(config),
        }
    )  # fmt: skip


def alternative_particles(config: LocalizationConfig) -> int:
    """Return the number of particles of an alternative initially and, at most, until it has converged."""
    return max(100, round(SEARCHED * config.global_particles))


def near(poses: Float64Array, pose: Float64Array) -> NDArray[np.bool_]:
    """Return which of ``poses`` (n, 3) may belong to a converged filter at ``pose`` (3,)."""
    off = poses - pose
    is_close = np.hypot(off[:, 0], off[:, 1]) <= LOST_TIMES * CONVERGED_M
    return is_close & (np.abs(wrap_angle(off[:, 2])) <= LOST_TIMES * CONVERGED_RAD)
