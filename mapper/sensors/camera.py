"""The pinhole model of a rectified camera.

The pixel (u, v) with the depth z is the point ((u − cx) z / fx, (v − cy) z / fy, z) in the camera's optical frame: x to
the right, y down, z ahead (REP 103). Source: sensor_msgs/CameraInfo; Hartley & Zisserman, Multiple View Geometry, 6.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Of a rectified image of ``width`` × ``height`` pixels: focal lengths and optical centre, pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        finite = math.isfinite(self.fx + self.fy + self.cx + self.cy)
        if not (finite and self.fx > 0.0 and self.fy > 0.0):
            raise ConfigError(
                "camera.intrinsics",
                "A camera’s focal lengths must be positive and its centre finite, not "
                f"{self.fx}, {self.fy}, {self.cx}, {self.cy}.",
            )

    def beams(self) -> tuple[float, float]:
        """Return angle_min and angle_increment, radians, of a scan with one beam for each column of the image."""
        last = math.atan2(self.cx, self.fx)
        first = -math.atan2(self.width - 1 - self.cx, self.fx)
        return first, (last - first) / max(1, self.width - 1)

    def projection(self, T_camera_map: NDArray[np.float64]) -> NDArray[np.float64]:  # noqa: N803
        """Return the matrix (3, 4) that takes (x, y, z, 1), metres in the map, to (u w, v w, w).

        w is the depth, metres, negative behind the camera; u and v are shares of the image's width and height, from its
        upper left corner. ``T_camera_map`` (4, 4) takes the map's coordinates to those of the optical frame. The centre
        of the first pixel is (0, 0) in pixels, and half a pixel from the corner.
        """
        camera = np.array(
            [
                [self.fx / self.width, 0.0, (self.cx + 0.5) / self.width],
                [0.0, self.fy / self.height, (self.cy + 0.5) / self.height],
                [0.0, 0.0, 1.0],
            ]
        )
        return camera @ T_camera_map[:3]

    def check_size(self, depth: NDArray[Any], what: str) -> None:
        """Raise :class:`ConfigError` for an image (height, width) of another size; ``what`` names what this is from."""
        if depth.shape != (self.height, self.width):
            raise ConfigError(
                "camera.size",
                f"an image of {depth.shape[1]} × {depth.shape[0]} pixels has {what} for {self.width} × {self.height}",
            )

    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the points (height × width, 3) of a depth image (height, width), metres, in the optical frame.

        Row after row, each with the depth's NaN where it has one. Raises as :meth:`check_size`.
        """
        self.check_size(depth, "intrinsics")
        z = depth.astype(np.float64)
        points = np.empty((*depth.shape, 3))
        points[..., 0] = (np.arange(self.width) - self.cx) / self.fx * z
        points[..., 1] = ((np.arange(self.height) - self.cy) / self.fy)[:, np.newaxis] * z
        points[..., 2] = z
        return points.reshape(-1, 3)
