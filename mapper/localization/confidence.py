"""Test whether a converged filter can be sure of its place.

Agreement of the particles does not show that the place is right, because they keep one of several similar places. Two
conditions do. First, the map must explain the readings: beams that pass through walls contradict a place, and a scan of
which the map explains little was taken elsewhere, or the map is outdated. Second, alternatives at other places, which
are started repeatedly (:mod:`mapper.localization.recovery`), must be ruled out by their tests one after another and
soon; a long test means that another place explains the scans nearly as well. In an outdated map a wrong place may
explain furniture better than the right one, and more alternatives must be ruled out. If the estimate jumps relative to
the odometry, earlier results do not apply to the new place.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.localization.kernels.scan_at_pose import count_unexplained
from mapper.localization.map_model import MapModel
from mapper.localization.scan_beams import ScanBeams

TURN, MARGIN = math.radians(2.0), 0.3  #: tolerances of bearings and ranges without a contradiction; m
RATE = 0.3  #: of the moving average of the fraction of contradicted readings
MOST_CONTRADICTED = 0.15  #: maximum of that average for a filter that is sure
MOST_UNEXPLAINED = 0.4  #: maximum fraction of readings of the newest scan that are longer or shorter than in the map
REFUTED = 0.3  #: average above which the place has to be confirmed again
WANTED = 5  #: number of alternatives in a row that must be ruled out,
WANTED_IN_CHANGED = 8  #: and if the map is known to be outdated
CHANGED_RATE = 0.03  #: of the slow moving average of the fraction of contradicted readings,
CHANGED = 0.02  #: above which the map is outdated
SOON = 8  #: maximum number of scans for each
JUMP_M, JUMP_RAD = 0.5, math.radians(20.0)  #: deviation of an estimate from the odometry that counts as another place


def is_jump(expected: Float64Array, estimated: Float64Array) -> BoolArray:
    """Return where poses ``estimated`` (n, 3) are at another place than ``expected`` (n, 3) from the odometry."""
    off = compose(inverse(expected), estimated)
    jumped: BoolArray = (np.hypot(off[:, 0], off[:, 1]) > JUMP_M) | (np.abs(wrap_angle(off[:, 2])) > JUMP_RAD)
    return jumped


def unexplained_shares(model: MapModel, scan: ScanBeams, pose: Float64Array) -> tuple[float, float]:
    """Return the fractions, 0 to 1, of a scan's readings that are longer and shorter than in the map at ``pose`` (3,).

    The longer ones pass through walls.
    """
    n = len(scan.beams)
    if not n:
        return 0.0, 0.0
    longer, shorter = count_unexplained(model.cells, scan.beams, scan.sensor, pose, TURN, MARGIN, scan.range_max)
    return longer / n, shorter / n


class Confidence:
    """Evidence for and against the place of one filter since it converged there."""

    def __init__(self) -> None:
        self.contradicted = 0.0  #: moving average of the fraction of contradicted readings
        self._changed = 0.0  # its slow average over all partly confirmed places, a property of the map
        self._unexplained = 0.0
        self._ruled_out = 0  # number of alternatives in a row
        self._is_rivalled = False  # whether the current alternative explains the scans since its start better

    def glance(self, longer: float, shorter: float) -> None:
        """Record the fractions of a scan's readings that are longer and shorter than in the map at the estimate."""
        self._unexplained = longer + shorter

    def look(self, longer: float, shorter: float) -> None:
        """Like :meth:`glance`, for a scan that the filter used; also updates the averages."""
        self.glance(longer, shorter)
        self.contradicted += RATE * (longer - self.contradicted)
        if self._ruled_out:  # at an unconfirmed place, contradictions do not apply to the map
            self._changed += CHANGED_RATE * (longer - self._changed)
        if self.contradicted > REFUTED:
            self.doubt()

    def rule_out(self, scans: int) -> None:
        """Record that an alternative was ruled out by ``scans`` scans."""
        if scans <= SOON:
            self._ruled_out += 1

    def wait(self, scans: int = 0, log_ratio: float = 0.0) -> None:
        """Record that an alternative, exp(``log_ratio``) times as likely, is not ruled out after this many scans.

        Without arguments: there is no alternative.
        """
        self._is_rivalled = log_ratio > 0.0
        if scans > SOON:
            self.doubt()

    def doubt(self) -> None:
        """Start again, because the filter is elsewhere or another place is more likely."""
        self._ruled_out = 0

    @property
    def is_confirmed(self) -> bool:
        """Whether enough alternatives were ruled out, and the map explains the readings at the place."""
        is_explained = self.contradicted <= MOST_CONTRADICTED and self._unexplained <= MOST_UNEXPLAINED
        needed = WANTED if self._changed <= CHANGED else WANTED_IN_CHANGED
        return self._ruled_out >= needed and is_explained and not self._is_rivalled
