"""Detection that the filter has lost the robot, and a second hypothesis with the test that decides between the two.

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
from mapper.localization.estimate import CONVERGED_M, CONVERGED_RAD, LOST_SHARE, LOST_TIMES, Estimate
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.scan_beams import ScanBeams

RATE = 0.4  #: of the moving average of the fit of scans relative to the best fit anywhere
#: Number of comparisons before the first reset, and its maximum before later ones: each reset doubles it, and each scan
#: that fits reduces it by one.
PATIENCE, MOST_PATIENCE = 4, 64
INTERVAL = 2  #: updates between two comparisons
LOST, SEARCHING = 0.5, 0.1  #: weight of added particles: when the robot is lost, and while it is being searched


def averaged(average: float, slow: float, fast: float, config: LocalizationConfig) -> tuple[float, float]:
    """Return w_slow and w_fast after a scan whose weights have this ``average``. Table 8.3, lines 10 and 11."""
    slow += config.recovery_alpha_slow * (average - slow)
    fast += config.recovery_alpha_fast * (average - fast)
    return slow, fast


class Recovery:
    """Moving averages of the relative fit of scans, and of the weights (augmented MCL).

    The robot ``is_searched`` from a global start, from a reset, or from when no cluster has half of the weight, until
    the filter has converged. A filter that only becomes wider, as in a long corridor, has not lost the robot.
    """

    def __init__(self, config: LocalizationConfig, *, is_searched: bool) -> None:
        self._config = config
        self.is_searched = is_searched
        self._ratio = 1.0
        self._compared = 0
        self._patience = PATIENCE
        self._slow = self._fast = 0.0
        self._updates = 0

    def wants_comparison(self) -> bool:
        """Return whether the next scan is to be compared with poses all over the map."""
        self._updates += 1
        return self._config.reset_below > 0.0 and self._updates % INTERVAL == 0

    def added_weight(self, fit: float, best: float, *, is_converged: bool, share: float = 1.0) -> float:
        """Return the weight of particles to add that are drawn from the likelihood of a scan; 0 for none.

        ``fit`` is the scan's fit at the particles, ``best`` its fit at the best of many poses. While the robot is
        searched, there may be no particle near it even if some fit well, so a few are always added. ``share`` is the
        weight of the heaviest cluster.
        """
        self.is_searched = not is_converged and (self.is_searched or share < LOST_SHARE)
        if self.is_searched:
            return SEARCHING
        self._compared += 1
        self._ratio += RATE * (fit / max(fit, best, 1e-9) - self._ratio)
        if self._ratio >= self._config.reset_below:
            self._patience = max(self._patience - 1, PATIENCE)
            return 0.0
        if self._compared < self._patience:
            return 0.0
        # If no pose explains the scans well, resets return to the same place and become rare.
        self.is_searched = True
        self._ratio, self._compared = 1.0, 0
        self._patience = min(2 * self._patience, MOST_PATIENCE)
        return LOST

    def random_share(self, log_likelihoods: Float64Array, n_beams: int) -> float:
        """Return the fraction of random particles that augmented MCL adds after a scan, 0 if it is disabled.

        The averages are reset when it is above 0, as in AMCL. They are of the n-th root of the product of n beams,
        because the product changes by orders of magnitude between scans.
        """
        config = self._config
        if config.recovery_alpha_slow == 0.0:
            return 0.0
        root = 1.0 if config.laser_model_type == "likelihood_field" else 1.0 / max(n_beams, 1)
        average = float(np.mean(np.exp(root * log_likelihoods)))
        if self._slow == 0.0:
            self._slow = self._fast = average
        self._slow, self._fast = averaged(average, self._slow, self._fast, config)
        share = max(0.0, 1.0 - self._fast / self._slow)
        if share > 0.0:
            self._slow = self._fast = 0.0
        return share


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
