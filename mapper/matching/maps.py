"""Map-to-map matching: the pose at which the walls of one occupancy grid coincide with those of another."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.matching.kernels.types import NO_POINT
from mapper.matching.match import Match, match_scan
from mapper.matching.parameters import MAP_CONFIG, MatchConfig
from mapper.matching.target import check_points, map_points, map_target

WINDOW_M = 5.0  #: around a guess
COARSE, COARSE_TURN = 0.2, math.radians(2.0)  #: metres, radians: of the search over a whole map
MODES = 6  #: modes that are refined


def place_map(first: OccupancyGrid, second: OccupancyGrid, guess: Float64Array | None = None) -> Match:
    """Return the pose of the second map in the first: a match with several candidates, best first.

    The poses are ``T_first_second``. Without a ``guess`` (3,), the centre of the second map's walls is searched over
    the extent of the first map's walls, in all directions; with a guess, within 5 m of where it places that centre.
    Raises the errors of :func:`match_maps`, and :class:`LimitError` for maps that are too large to search.
    """
    target, walls = map_target(map_points(first)), map_points(second)
    theirs, ours = target.points, walls.points[0, walls.kind[0] != NO_POINT]
    check_points(walls, np.zeros(1, dtype=np.int64), "the map")
    middle = np.array([*ours.mean(axis=0), 0.0])
    if guess is None:
        low, high = theirs.min(axis=0), theirs.max(axis=0)
        begin, window = np.array([*(0.5 * (low + high)), 0.0]), max(WINDOW_M, float(np.max(high - low)) / 2.0)
    else:
        begin, window = compose(np.asarray(guess, dtype=np.float64), middle), WINDOW_M
    # Rotated about the centre, the walls stay within the window.
    points = walls.points - middle[:2].astype(np.float32)
    config = MAP_CONFIG.with_values(
        {
            "window_m": window, "field_resolution": COARSE, "field_sigma": COARSE, "turn_step": COARSE_TURN,
            "modes": MODES, "mode_share": 0.5,
        }
    )  # fmt: skip
    match = match_scan(walls._replace(points=points), 0, target, begin, config)
    order = np.argsort(-match.scores, kind="stable")
    candidates = compose(match.candidates[order], inverse(middle))
    return replace(match, pose=candidates[0], candidates=candidates, scores=match.scores[order])


def match_maps(
    first: OccupancyGrid, second: OccupancyGrid, guess: Float64Array | None = None, config: MatchConfig = MAP_CONFIG
) -> Match:
    """Return the pose of the second map's frame in that of the first, ``T_first_second``, from ``guess`` (3,) or 0.

    The centres of the second map's occupied cells are matched to those of the first like the points of a scan: a search
    over the window, then Gauss–Newton on a field. Raises :class:`ConfigError` for a map with fewer than three occupied
    cells, and the errors of :func:`mapper.matching.match.match_scan`.
    """
    target = map_target(map_points(first))
    return match_scan(map_points(second), 0, target, np.zeros(3) if guess is None else guess, config)
