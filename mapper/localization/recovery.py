"""Detection that the filter has lost the robot."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.localization.estimate import LOST_SHARE
from mapper.localization.parameters import LocalizationConfig

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
