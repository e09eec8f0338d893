"""The points of an uploaded cloud or recording, and which of them are ground."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

from mapper.core.array_types import BoolArray, Float64Array, Int64Array
from mapper.core.sampling import sample_rows
from mapper.volume.scans.scan_sequence import ScanSequence

if TYPE_CHECKING:
    from server.library.packs.volume import VolumeSource

MOST_POINTS = 2_000_000  #: a larger cloud is sampled
SAME_M = 0.002  #: two points this close are the same, because float32 values in two files differ in the last digits
LEAST_SHARE = 0.9  #: least share of the other cloud's points that must match for it to count as the ground of this one
GROUND_CLASS = 2  #: of the ASPRS LAS specification


class CloudPoints:
    """The points of ``scans`` within the bounds x0, y0, x1, y1 of ``low`` and ``high`` (3,); none without scans.

    ``other`` is the title and the source of the file with which this one is compared. If it is a part of this cloud, it
    counts as its ground; without it, the points of class "ground" do, if the file has classes.
    """

    def __init__(
        self, scans: ScanSequence | None, low: Float64Array, high: Float64Array,
        other: tuple[str, VolumeSource] | None = None,
    ) -> None:  # fmt: skip
        self._scans, self._other = scans, other
        self._bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))

    @property
    def count(self) -> int:
        """1, because all scans are used at once; 0 for an octree, which has no points."""
        return int(self._scans is not None)

    @property
    def truth(self) -> str | None:
        """Source of the known ground points: the name of a file, or the classes; None if there is none."""
        return None if self._scans is None else self._known_ground[0]

    def points(self) -> Float64Array:
        """Return the points (n, 3) within the bounds."""
        return self._inside()[0]

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return the points (n, 3), the bounds, and which points are ground, None if unknown."""
        if self._scans is None:
            return np.empty((0, 3)), self._bounds, None
        points, rows = self._inside()
        ground = self._known_ground[1]
        return points, self._bounds, None if ground is None else ground[rows]

    def _inside(self) -> tuple[Float64Array, Int64Array]:
        """Return at most :data:`MOST_POINTS` points (n, 3) within the bounds, and their indices (n,)."""
        if self._scans is None:
            return np.empty((0, 3)), np.empty(0, np.int64)
        some = sample_rows(len(self._scans.points), MOST_POINTS)
        points = self._scans.points[some]
        x0, y0, x1, y1 = self._bounds
        x, y = points[:, 0], points[:, 1]
        rows = np.flatnonzero((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
        return points[rows].astype(np.float64), some[rows]

    @cached_property
    def _known_ground(self) -> tuple[str | None, BoolArray | None]:
        scans = self._scans
        if scans is None:
            return None, None
        title, part = self._other or (None, None)
        if isinstance(part, ScanSequence):
            tree = KDTree(part.points.astype(np.float64) + (part.offset - scans.offset))
            far, nearest = tree.query(scans.points.astype(np.float64), distance_upper_bound=SAME_M)
            is_ground = np.asarray(np.isfinite(far))
            if len(np.unique(nearest[is_ground])) >= LEAST_SHARE * len(part.points):
                return title, is_ground
        classes = scans.fields.get("class")
        if classes is not None:
            of_class = np.asarray(classes).reshape(-1) == GROUND_CLASS
            if of_class.any() and not of_class.all():
                return "the file’s classes", of_class
        return None, None
