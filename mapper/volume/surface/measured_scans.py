"""Measurements of a surface: depth images, or points with the position of their sensor."""

from __future__ import annotations

from typing import Protocol

from mapper.sensors.depth_image import DepthImage
from mapper.volume.placed_scan import PlacedScan


class MeasuredScans(Protocol):
    """Scans in their order."""

    @property
    def has_origins(self) -> bool:
        """Whether it is known of all where their sensor was."""

    def __len__(self) -> int: ...

    def depth_image(self, index: int) -> DepthImage | None:
        """Return the depth image of a scan; None where it has points only."""

    def scan(self, index: int) -> PlacedScan:
        """Return the points of a scan."""
