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
                "A camera's focal lengths must be positive and its centre finite, not "
                f"{self.fx}, {self.fy}, {self.cx}, {self.cy}.",
            )

    def beams(self) -> tuple[float, float]:
        """Return angle_min and angle_increment, radians, of a scan with one beam for each column of the image."""
        last = math.atan2(self.cx, self.fx)
        first = -math.atan2(self.width - 1 - self.cx, self.fx)
        return first, (last - first) / max(1, self.width - 1)

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
