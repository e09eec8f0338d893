"""The scans of one sensor as a log has them, each with the beams and the limits that it states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.scan import MAX_STATED_S


class Beaming(NamedTuple):
    """What a message, or a line, states of its beams: radians, metres, their number."""

    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    beams: int


@dataclass(frozen=True, slots=True)
class StatedScans:
    """The scans of one sensor, with what they state; ``where`` its messages are ("on /scan"), for notes.

    ``beamings`` are what scans state of their beams, each once, and ``beaming_of_scan`` (n_scans,) the index of each
    scan's in them. ``readings`` are those of all scans, metres, one scan after the other, and ``time_increments``
    (n_scans,) the stated times between two beams, seconds, which may be anything. ``is_cut``: the scans were cut out of
    clouds or depth images, so that their limits are those of the cut.
    """

    where: str
    beamings: list[Beaming]
    beaming_of_scan: NDArray[np.int64]
    readings: NDArray[np.float32]
    time_increments: NDArray[np.float32]
    is_cut: bool = False

    @property
    def n_scans(self) -> int:
        """Number of scans."""
        return len(self.beaming_of_scan)

    @property
    def usual(self) -> Beaming:
        """The beams that most scans have."""
        return self.beamings[int(np.argmax(np.bincount(self.beaming_of_scan)))]


def median_seconds(stated: NDArray[np.float32]) -> float:
    """Return the median of the stated times that are finite and not absurd, else 0."""
    good = stated[np.abs(stated) <= MAX_STATED_S]  # false for NaN
    return float(np.median(good)) if len(good) else 0.0
