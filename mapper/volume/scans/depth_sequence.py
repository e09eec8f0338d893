"""The depth images of a folder in memory, to be fused again and again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float32Array, Float64Array
from mapper.sensors.camera import Intrinsics

MOST_PIXELS = 1 << 26  #: of all images that are kept, 128 MiB: 218 images of 640 × 480
LEAST_AGREEMENT = 0.5  #: length of the mean of unit vectors below which they do not say one direction


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
        """Return which way is up, a unit vector (3,) of the map's frame: against the mean of the images' columns.

        None where the cameras do not agree: they look straight up and down, or turn about their axes.
        """
        mean = -self.poses[:, :3, 1].mean(axis=0)
        length = float(np.linalg.norm(mean))
        return np.asarray(mean / length) if length > LEAST_AGREEMENT else None

    def depth(self, index: int) -> Float32Array:
        """Return an image (height, width), metres along the optical axis; 0 is no depth."""
        depth: Float32Array = self.images[index].astype(np.float32) * np.float32(self.unit)
        return depth


class GatheredDepth:
    """Depth images while they are read. Once there are too many pixels, every second row and column is kept."""

    def __init__(self, camera: Intrinsics, unit: float, most: int = MOST_PIXELS) -> None:
        self._camera, self._unit, self._most = camera, unit, most
        self._step = 1  #: rows and columns from one that is kept to the next
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
        """A sentence where not all pixels are kept."""
        if self._step == 1:
            return []
        return [
            f"Of each image one of {self._step} rows and columns is kept for surfaces: the images have too many pixels."
        ]

    def sequence(self, offset: Float64Array) -> DepthSequence:
        """Return the images in a map that is moved by −``offset`` (3,). There must be one at least."""
        images, poses = np.stack(self._images), np.array(self._poses)
        poses[:, :3, 3] -= offset
        _, height, width = images.shape
        full, step = self._camera, self._step
        # Pixel (u, v) is what was pixel (step u, step v).
        camera = Intrinsics(width, height, full.fx / step, full.fy / step, full.cx / step, full.cy / step)
        return DepthSequence(camera, self._unit, images, poses)
