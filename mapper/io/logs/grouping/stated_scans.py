"""Scans of one sensor as stated in a log, each with its own beams and limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.scan import MAX_STATED_S


class Beaming(NamedTuple):
    """The beams stated by a message or line: radians, metres, their number."""

    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    beams: int


@dataclass(frozen=True, slots=True)
class StatedScans:
    """The scans of one sensor as stated; ``where`` describes its messages ("on /scan") in notes.

    ``beamings`` are the distinct stated beams, and ``beaming_of_scan`` (n_scans,) the index of each scan's.
    ``readings`` are those of all scans, metres, concatenated, and ``time_increments`` (n_scans,) the stated times
    between two beams, seconds, of any value. ``is_cut``: the scans were extracted from clouds or depth images, so their
    limits are those of the extraction.
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
        """The most common beams."""
        return self.beamings[int(np.argmax(np.bincount(self.beaming_of_scan)))]


def median_seconds(stated: NDArray[np.float32]) -> float:
    """Return the median of the stated times that are finite and plausible, else 0."""
    good = stated[np.abs(stated) <= MAX_STATED_S]  # false for NaN
    return float(np.median(good)) if len(good) else 0.0
