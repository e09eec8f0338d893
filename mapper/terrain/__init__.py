"""Terrain from points: ground points, planes of patches, and traversability."""

from mapper.terrain.ground import Ground, agreement, find_ground
from mapper.terrain.parameters import GROUND_PARAMETERS, PATCH_PARAMETERS, GroundConfig, PatchConfig
from mapper.terrain.patches import SAFE, UNKNOWN, UNSAFE, Patches, PointIndex, Terrain, agreeing, assess, fitted

__all__ = [
    "GROUND_PARAMETERS",
    "PATCH_PARAMETERS",
    "SAFE",
    "UNKNOWN",
    "UNSAFE",
    "Ground",
    "GroundConfig",
    "PatchConfig",
    "Patches",
    "PointIndex",
    "Terrain",
    "agreeing",
    "agreement",
    "assess",
    "find_ground",
    "fitted",
]
