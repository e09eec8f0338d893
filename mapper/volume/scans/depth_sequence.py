"""Depth images of a folder in memory, for repeated fusion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array
from mapper.sensors.camera import Intrinsics

MOST_PIXELS = 1 << 26  #: of all images kept, 128 MiB: 218 images of 640 × 480
LEAST_AGREEMENT = 0.5  #: minimum length of the mean of unit vectors for a common direction


@dataclass(frozen=True, slots=True)
class DepthSequence:
    """Depth images of one ``camera``: ``images`` (n, height, width) uint16 in steps of ``unit`` metres, 0 for no depth.

    ``poses`` (n, 4, 4) are ``T_map_camera`` of the camera's optical frame.
    """

    camera: Intrinsics
    unit: float
    images: NDArray[np.uint16]
    poses: Float64Array

    @property
    def up(self) -> Float64Array | None:
        """Return the upward direction, a unit vector (3,) in the map's frame: opposite to the mean image column
        direction.

        None if the cameras do not agree, because they look straight up and down or rotate about their axes.
        """
        mean = -self.poses[:, :3, 1].mean(axis=0)
        length = float(np.linalg.norm(mean))
        return np.asarray(mean / length) if length > LEAST_AGREEMENT else None

    def depth(self, index: int) -> Float32Array:
        """Return an image (height, width), metres along the optical axis; 0 is no depth."""
        depth: Float32Array = self.images[index].astype(np.float32) * np.float32(self.unit)
        return depth


class GatheredDepth:
    """Depth images being read. If there are too many pixels, every second row and column is kept."""

    def __init__(self, camera: Intrinsics, unit: float, most: int = MOST_PIXELS) -> None:
        self._camera, self._unit, self._most = camera, unit, most
        self._step = 1  #: step between kept rows and columns
        self._images: list[NDArray[np.uint16]] = []
        self._poses: list[Float64Array] = []
        self._pixels = 0

    def add(self, depth: Float32Array, pose: Float64Array) -> None:
        """Add an image (height, width), metres, NaN for no depth, at ``pose`` (4, 4)."""
        raw = np.rint(np.nan_to_num(depth, nan=0.0) / self._unit).astype(np.uint16)
        self._images.append(np.ascontiguousarray(raw[:: self._step, :: self._step]))
        self._poses.append(pose)
        self._pixels += self._images[-1].size
        while self._pixels > self._most and min(self._images[-1].shape) > 1:
            self._step *= 2
            self._images = [np.ascontiguousarray(image[::2, ::2]) for image in self._images]
            self._pixels = sum(image.size for image in self._images)

    @property
    def notes(self) -> list[str]:
        """A sentence if not all pixels are kept."""
        if self._step == 1:
            return []
        return [
            f"Of each image one of {self._step} rows and columns is kept for surfaces: the images have too many pixels."
        ]

    def sequence(self, offset: Float64Array) -> DepthSequence:
        """Return the images in a map shifted by −``offset`` (3,). There must be at least one."""
        images, poses = np.stack(self._images), np.array(self._poses)
        poses[:, :3, 3] -= offset
        _, height, width = images.shape
        full, step = self._camera, self._step
        # Pixel (u, v) was pixel (step u, step v).
        camera = Intrinsics(width, height, full.fx / step, full.fy / step, full.cx / step, full.cy / step)
        return DepthSequence(camera, self._unit, images, poses)
