"""Scan matching: the relative pose that aligns two scans, a scan and a map, or two maps."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later
from mapper.matching.parameters import METHODS, PARAMETERS, MatchConfig

if TYPE_CHECKING:
    from mapper.matching.beams import prepare_scans
    from mapper.matching.maps import match_maps
    from mapper.matching.match import Match, match_scan
    from mapper.matching.target import Target, map_points, map_target, scan_target

__all__ = [
    "METHODS",
    "PARAMETERS",
    "Match",
    "MatchConfig",
    "Target",
    "map_points",
    "map_target",
    "match_maps",
    "match_scan",
    "prepare_scans",
    "scan_target",
]

# The command imports only the parameters, for its options.
__getattr__ = imported_later(__name__, __file__)
