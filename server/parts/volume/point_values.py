"""Values by which a cloud's points are coloured: intensity, time of the scan, distance to another cloud."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.sampling import sample_rows
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.look import COLOURS
from server.stream.message_parts import ColourScale

MOST_COMPARED = 2_000_000  #: points of either cloud; a larger one is sampled
LEAST_DIFFERENCE_M = 0.01  #: least value at the end of the scale
UNITS = {"intensity": "", "time": "s", "difference": "m"}


class PointValues:
    """Values of each point of ``scans``, None for a map without points. ``other`` is compared with them."""

    def __init__(self, scans: ScanSequence | None, other: ScanSequence | None = None) -> None:
        self._scans, self._other = scans, other
        self._banded: tuple[str, UInt8Array, ColourScale] | None = None  #: the values requested last

    @cached_property
    def names(self) -> list[str]:
        """The colourings of the points, besides their height."""
        scans = self._scans
        if scans is None:
            return []
        names = ["own colour" if name == "rgb" else name for name in scans.fields]
        return names + ["time"] * (len(scans) > 1) + ["difference"] * (self._other is not None)

    def is_banded(self, name: str) -> bool:
        """Return whether a colouring shows a value of the points, in :data:`COLOURS` steps."""
        return name in UNITS and name in self.names

    def scale(self, name: str) -> ColourScale | None:
        """Return the least and the greatest value of a colouring, once known."""
        return self._banded[2] if self._banded is not None and self._banded[0] == name else None

    def bands(self, name: str) -> UInt8Array:
        """Return the steps (n,), 0 to :data:`COLOURS` − 1, of the values of all points; NaN is in the first step."""
        if self._banded is None or self._banded[0] != name:
            values, low, high = getattr(self, f"_{name}")()
            steps = (values - low) * (COLOURS / max(high - low, 1e-9))
            bands = np.fmin(np.fmax(steps, 0.0), COLOURS - 1.0).astype(np.uint8)
            unit = "scan" if name == "time" and not self._has_stamps else UNITS[name]
            self._banded = name, bands, ColourScale(low, high, unit)
        return self._banded[1]

    @property
    def _has_stamps(self) -> bool:
        stamps = self._sequence.stamps_ns
        return bool(stamps.min() < stamps.max())

    @property
    def _sequence(self) -> ScanSequence:
        if self._scans is None:
            raise ValueError("a map without points has no numbers of them")
        return self._scans

    def _intensity(self) -> tuple[Float64Array, float, float]:
        values = self._sequence.fields["intensity"].astype(np.float64)
        low, high = np.nanpercentile(values, [1.0, 99.0]) if len(values) else (0.0, 1.0)
        return values, float(low), float(high)

    def _time(self) -> tuple[Float64Array, float, float]:
        """Return the times of the points' scans since the first, seconds; without times, their numbers from 1."""
        scans = self._sequence
        times = np.arange(1.0, len(scans) + 1.0)
        if self._has_stamps:
            times = np.asarray((scans.stamps_ns - scans.stamps_ns.min()).astype(np.float64) * 1e-9)
        return np.repeat(times, np.diff(scans.starts)), float(times.min()), float(times.max())

    def _difference(self) -> tuple[Float64Array, float, float]:
        """Return the distance of the nearest point of the other cloud, metres.

        A point outside the sample has the value of the previous one in it. The scale ends where one in a hundred points
        is farther away.
        """
        scans, other = self._sequence, self._other
        if other is None:
            raise ValueError("there is no other cloud")
        its = other.points[sample_rows(len(other.points), MOST_COMPARED)]
        tree = KDTree(its.astype(np.float64) + (other.offset - scans.offset))
        some = sample_rows(len(scans.points), MOST_COMPARED)
        far, _ = tree.query(scans.points[some].astype(np.float64))
        high = float(np.percentile(far, 99.0)) if len(far) else 0.0
        before = np.searchsorted(some, np.arange(len(scans.points)), side="right") - 1
        return far[np.maximum(before, 0)], 0.0, max(high, LEAST_DIFFERENCE_M)
