"""The points of an uploaded cloud or recording, as a terrain takes them."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array
from mapper.volume.scan_sequence import ScanSequence
from server.sessions.models.lab_terrain import TerrainParameters

MOST_POINTS = 2_000_000  #: of a larger cloud every second point is taken, or fewer


class CloudPoints:
    """The points of ``scans`` within the bounds x0, y0, x1, y1 of ``low`` and ``high`` (3,); none without scans."""

    def __init__(self, scans: ScanSequence | None, low: Float64Array, high: Float64Array) -> None:
        self._scans = scans
        self._bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))

    @property
    def count(self) -> int:
        """1: all scans are taken at once; 0 for an octree, which has no points."""
        return int(self._scans is not None)

    @property
    def first(self) -> TerrainParameters:
        """The parameters to begin with, for this density of points."""
        x0, y0, x1, y1 = self._bounds
        return TerrainParameters.outdoors(0 if self._scans is None else len(self._scans.points), (x1 - x0) * (y1 - y0))

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return the points (n, 3), the bounds, and that it is not known which are ground."""
        if self._scans is None:
            return np.empty((0, 3)), self._bounds, None
        points = self._scans.points[:: max(1, -(-len(self._scans.points) // MOST_POINTS))]
        x0, y0, x1, y1 = self._bounds
        x, y = points[:, 0], points[:, 1]
        return points[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)].astype(np.float64), self._bounds, None
