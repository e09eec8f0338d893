"""The surface of the lab's 3D scans from truncated signed distances, shown instead of the octree."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.sensors.depth_image import DepthImage
from mapper.simulation.sensors_3d import Scan3D
from mapper.volume.placed_scan import PlacedScan
from server.parts.volume.live_volume import LabVolume, lab_limits
from server.parts.volume.look import Look
from server.parts.volume.messages import SurfaceMessage
from server.parts.volume.parameters import VolumeParameters
from server.parts.volume.surface import VolumeSurface
from server.sessions.drawings import Surface

FUSING_S = 0.05  #: longest time of fusing scans in one tick; the others wait for the next tick


@dataclass(frozen=True, slots=True, eq=False)
class LabScans:
    """Scans of the lab's robot in the form that a surface uses: depth images, or end points of a lidar's beams."""

    scans: list[Scan3D]

    @property
    def has_origins(self) -> bool:
        """True, because the robot knows the pose of its sensor."""
        return True

    def __len__(self) -> int:
        return len(self.scans)

    def depth_image(self, index: int) -> DepthImage | None:
        """Return the image of a depth camera; None for a lidar's scan."""
        return self.scans[index].depth_image()

    def scan(self, index: int) -> PlacedScan:
        """Return the end points of a scan's beams. Those without a return say nothing about a surface."""
        scan = self.scans[index]
        points, origin = scan.ends()
        return PlacedScan(points[np.isfinite(scan.ranges)], origin)


class LabSurface:
    """A surface of all recorded scans of ``volume``, extended with each :meth:`catch_up`."""

    def __init__(self, volume: LabVolume, limits: Callable[[], Limits]) -> None:
        self._made, self._scans = volume, volume.scans
        config = volume.parameters.surface
        self.surface = VolumeSurface(
            LabScans(self._scans), config.resolution, lambda: lab_limits(limits()), snapshot_bytes=0
        )
        self.surface.use(config)
        self._problem: str | None = None  #: why some scans are not in the surface
        self.is_unmeshed = True  #: whether blocks may have changed since they were meshed

    def change(self, parameters: VolumeParameters) -> bool:
        """Use other parameters; return whether the surface is recomputed."""
        if not self.surface.use(parameters.surface):
            return False
        self._problem, self.is_unmeshed = None, True
        return True

    @property
    def index(self) -> int:
        """Number of scans in the surface."""
        return self.surface.replayed.index

    @property
    def is_behind(self) -> bool:
        """Whether recorded scans are not in the surface yet."""
        return self._problem is None and (self._made.scans is not self._scans or self.index < len(self._scans))

    def catch_up(self) -> bool:
        """Fuse the next scans; return whether there were any."""
        if not self.is_behind:
            return False
        if self._made.scans is not self._scans:  # some scans were dropped, so the surface is that of the others
            self._scans = self._made.scans
            self.surface.set_source(LabScans(self._scans))
        began = time.monotonic()
        try:
            self.surface.replayed.go_to(len(self._scans), lambda: time.monotonic() - began > FUSING_S)
        except LimitError as error:
            self._problem = error.message
        self.is_unmeshed = True
        return True

    def mesh(self) -> None:
        """Mesh what has changed, or a part of it."""
        self.surface.mesh()
        self.is_unmeshed = self.surface.is_stale

    def drawing(self, look: Look) -> Surface:
        """Return the triangles in the clip box, coloured by height or by normal."""
        return self.surface.drawing(look, 0.0)

    def message(self) -> SurfaceMessage:
        """Return the ``surface`` message."""
        stated = self.surface.message()
        return stated if self._problem is None else msgspec.structs.replace(stated, problem=self._problem)
