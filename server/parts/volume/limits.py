"""The limits of a map in 3D of one visitor."""

from __future__ import annotations

from dataclasses import replace

from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.volume.blocks import BLOCK

MOST_SCAN_BOX = 1 << 31  #: voxels of the box around one scan: 200 × 200 × 50 m at 10 cm, some seconds


def map_limits(limits: Limits) -> Limits:
    """Return the limits of a map of a visitor with these: the cells that they may have are voxels here."""
    blocks = max(64, limits.max_cells // BLOCK**3)
    return replace(DEFAULT_LIMITS, max_blocks=min(DEFAULT_LIMITS.max_blocks, blocks), max_scan_box=MOST_SCAN_BOX)
