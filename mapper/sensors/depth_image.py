"""Depth images with poses: single images and those of a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.camera import Intrinsics
from mapper.sensors.point_cloud import PointCloud, PosedCloud, check_pose


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage:
    """Depths (height, width) float32 of ``camera``, metres along the optical axis, 0 for no depth.

    ``pose`` (4, 4) is ``T_map_camera`` of the camera's optical frame: x right, y down, z forward (REP 103).
    """

    depth: NDArray[np.float32]
    camera: Intrinsics
    pose: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DepthFrame:
    """One depth image; ``pose`` (4, 4) is ``T_map_camera`` of the camera's optical frame (z forward, y down).

    ``read`` returns the depths along the optical axis (height, width) float32, metres, NaN for no depth. It raises
    :class:`ReadError` for an image that cannot be read or whose size differs from the intrinsics.
    """

    name: str
    stamp_ns: int
    pose: NDArray[np.float64]
    read: Callable[[], NDArray[np.float32]]

    def __post_init__(self) -> None:
        check_pose(self.pose, f"The pose of {self.name}")


@dataclass(frozen=True, slots=True)
class DepthFolder:
    """The depth images of one camera, in order. Images are read on demand and not kept.

    Depths are integer multiples of ``unit`` metres, at most 65,535 of them, rounded to float32.
    """

    camera: Intrinsics
    frames: tuple[DepthFrame, ...]
    notes: tuple[str, ...] = ()
    unit: float = 0.001

    def __len__(self) -> int:
        return len(self.frames)

    def clouds(self) -> Iterator[PosedCloud]:
        """Yield each image as an organised cloud in the camera's optical frame, with NaN where it has no depth."""
        shape = (self.camera.height, self.camera.width)
        for frame in self.frames:
            cloud = PointCloud(self.camera.points(frame.read()), frame.stamp_ns, frame.name, shape)
            yield PosedCloud(cloud, frame.pose)
