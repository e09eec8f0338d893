"""Whether a filter that has converged may say that it is sure of the place.

That particles agree on a place does not tell that it is the right one: of several places that look alike they keep one.
Two things tell it. Readings contradict a place where beams go on behind walls of the map, and a scan of which the map
explains little was not taken there, or the map is not that of the place any more. And other places, on which
alternatives are begun again and again (:mod:`mapper.localization.recovery`), must be ruled out by their tests, one
after the other and soon: where a test takes long, another place explains the scans nearly as well. In a map that is out
of date a wrong place may explain furniture better than the right one, and more of them must be ruled out. Where the
estimate jumps beside the odometry, what was ruled out before says nothing of the new place.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.localization.kernels.scan_at_pose import count_unexplained
from mapper.localization.map_model import MapModel
from mapper.localization.scan_beams import ScanBeams

TURN, MARGIN = math.radians(2.0), 0.3  #: by which beams and ranges may be off without a contradiction; m
RATE = 0.3  #: of the average share of contradicted readings
MOST_CONTRADICTED = 0.15  #: of the readings, in that average, of a filter that is sure
MOST_UNEXPLAINED = 0.4  #: of the readings of the newest scan, longer or shorter than the map has it
REFUTED = 0.3  #: average from which on the place has to be confirmed again
WANTED = 5  #: alternatives in a row that must have been ruled out,
WANTED_IN_CHANGED = 8  #: and where the map is known to be out of date
CHANGED_RATE = 0.03  #: of the slow average share of contradicted readings,
CHANGED = 0.02  #: from which on the map is out of date
SOON = 8  #: scans within which each must be
JUMP_M, JUMP_RAD = 0.5, math.radians(20.0)  #: of an estimate beside the odometry, from which on it is another place


def is_jump(expected: Float64Array, estimated: Float64Array) -> BoolArray:
    """Return where poses ``estimated`` (n, 3) are another place than ``expected`` (n, 3), to which the odometry led."""
    off = compose(inverse(expected), estimated)
    jumped: BoolArray = (np.hypot(off[:, 0], off[:, 1]) > JUMP_M) | (np.abs(wrap_angle(off[:, 2])) > JUMP_RAD)
    return jumped


def unexplained_shares(model: MapModel, scan: ScanBeams, pose: Float64Array) -> tuple[float, float]:
    """Return the shares of a scan's readings, 0 to 1, that are longer and shorter than the map has it at ``pose`` (3,).

    The longer ones go on behind walls.
    """
    n = len(scan.beams)
    if not n:
        return 0.0, 0.0
    longer, shorter = count_unexplained(model.cells, scan.beams, scan.sensor, pose, TURN, MARGIN, scan.range_max)
    return longer / n, shorter / n


class Confidence:
    """What speaks for and against the place of one filter, since it has converged there."""

    def __init__(self) -> None:
        self.contradicted = 0.0  #: average share of contradicted readings
        self._changed = 0.0  # its slow average at all places that were confirmed in part: it is a property of the map
        self._unexplained = 0.0
        self._ruled_out = 0  # alternatives in a row
        self._is_rivalled = False  # whether the present alternative explains the scans since it began better

    def glance(self, longer: float, shorter: float) -> None:
        """Take the shares of a scan's readings that are longer and shorter than the map has it at the estimate."""
        self._unexplained = longer + shorter

    def look(self, longer: float, shorter: float) -> None:
        """Take those of a scan that the filter used, as :meth:`glance`: the averages follow."""
        self.glance(longer, shorter)
        self.contradicted += RATE * (longer - self.contradicted)
        if self._ruled_out:  # at a place that nothing speaks for, contradictions say nothing of the map
            self._changed += CHANGED_RATE * (longer - self._changed)
        if self.contradicted > REFUTED:
            self.doubt()

    def rule_out(self, scans: int) -> None:
        """Take note of an alternative that was ruled out by ``scans`` scans."""
        if scans <= SOON:
            self._ruled_out += 1

    def wait(self, scans: int = 0, log_ratio: float = 0.0) -> None:
        """Take note of an alternative that so many scans, exp(``log_ratio``) times as likely there, have not ruled out.

        Without arguments: of that there is none.
        """
        self._is_rivalled = log_ratio > 0.0
        if scans > SOON:
            self.doubt()

    def doubt(self) -> None:
        """Begin again: the filter is elsewhere, or another place is likelier."""
        self._ruled_out = 0

    @property
    def is_confirmed(self) -> bool:
        """Whether enough alternatives were ruled out, and the map explains the readings at the place."""
        is_explained = self.contradicted <= MOST_CONTRADICTED and self._unexplained <= MOST_UNEXPLAINED
        needed = WANTED if self._changed <= CHANGED else WANTED_IN_CHANGED
        return self._ruled_out >= needed and is_explained and not self._is_rivalled
