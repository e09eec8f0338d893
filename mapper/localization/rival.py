"""A second filter that begins elsewhere, where the first one may be in a place that only looks like the robot's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mapper.localization.monte_carlo import MonteCarloLocalizer

DOUBT_BELOW = 0.97  #: of the average ratio of the fit to the best fit in the map
SHORTEST, LONGEST = 12, 40  #: scans after which a rival may win, and after which it has lost
MARGIN = 0.02  #: by which it has to fit better, on average over the scans since it had converged
RATE = 0.15  #: of the averages


class Rival:
    """A filter beside the first one, and the averages of how well scans fit both while the rival has converged."""

    def __init__(self, robot: MonteCarloLocalizer) -> None:
        self.robot = robot
        self.age = 0
        self._converged = 0
        self._lead = 0.0

    def compare(self, fit: float) -> bool | None:
        """Take how a scan fits the first filter; return whether the rival has won, None while that is open."""
        self.age += 1
        if self.robot.estimate.is_converged:
            self._converged += 1
            self._lead += max(RATE, 1.0 / self._converged) * (self.robot.estimate.fit - fit - self._lead)
        else:
            self._converged, self._lead = 0, 0.0
        if self._converged >= SHORTEST and self._lead > MARGIN:
            return True
        return False if self.age >= LONGEST else None
