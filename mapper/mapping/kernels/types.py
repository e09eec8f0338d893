"""Tuples of arguments that the compiled updates take."""

from __future__ import annotations

import numpy as np

#: Where the lattice lies: origin x, y (m), cosine and sine of its yaw, resolution (m): ``GridGeometry.frame``.
Frame = tuple[float, float, float, float, float]
#: Which readings count and how: range_min, range_max, width of the hit window at no distance (m), how much wider it is
#: for each metre of range (m/m), whether no return says "free".
ReadingFilter = tuple[float, float, float, float, bool]
#: What they say, log-odds: miss, hit, lower and upper clamp.
LogOddsUpdate = tuple[np.float32, np.float32, np.float32, np.float32]
#: The same unrounded, for models whose evidence differs from cell to cell: miss, hit.
Evidence = tuple[float, float]
#: A cone: its profile (see :mod:`mapper.mapping.kernels.cones`) and its opening angle (rad).
Cone = tuple[int, float]
