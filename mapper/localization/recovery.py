"""Detection that the filter has lost the robot."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.localization.estimate import LOST_SHARE
from mapper.localization.parameters import LocalizationConfig

RATE = 0.4  #: of the average of how a scan fits, beside how it fits best anywhere
#: Scans that are compared before the first reset, and at most before a later one: each reset doubles their number,
#: each scan that fits takes one off.
PATIENCE, MOST_PATIENCE = 4, 64
INTERVAL = 2  #: updates from one comparison to the next
LOST, SEARCHING = 0.5, 0.1  #: weight of the particles that are added: once the robot is lost, and while it is searched


def averaged(average: float, slow: float, fast: float, config: LocalizationConfig) -> tuple[float, float]:
    """Return w_slow and w_fast after a scan whose weights have this ``average``. Table 8.3, lines 10 and 11."""
    slow += config.recovery_alpha_slow * (average - slow)
    fast += config.recovery_alpha_fast * (average - fast)
    return slow, fast


class Recovery:
    """Averages of how well scans fit compared with other poses in the map, and of the weights (augmented MCL).

    The robot ``is_searched`` from a start without a hint, from a reset, or from when no cluster has half of the weight,
    until the filter has converged. A filter that only gets wider, as in a long corridor, has not lost it.
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

        ``fit`` is how it fits the particles, ``best`` how it fits at the best of many poses. While the robot is
        searched there may be no particle near it, however well some fit: a few are added in any case. ``share`` is
        the weight of the heaviest cluster.
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
        # Where no pose explains the scans well, resets find the robot where it was: they become rare.
        self.is_searched = True
        self._ratio, self._compared = 1.0, 0
        self._patience = min(2 * self._patience, MOST_PATIENCE)
        return LOST

    def random_share(self, log_likelihoods: Float64Array, n_beams: int) -> float:
        """Return the share of random particles that augmented MCL adds after a scan, 0 where it is off.

        The averages begin again where it is above 0, as in AMCL. They are of the n-th root of the product of n beams: a
        product changes by orders of magnitude from scan to scan.
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
