"""A planar scan out of a depth image: the nearest pixel of some rows in each direction.

Source: the ROS package depthimage_to_laserscan, and its pinhole model: the pixel (u, v) with the depth z is the point
x = (u − cx) z / fx to the right of the optical axis. The camera is taken to be level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.sensors.planar.options import PlanarCut


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Of a rectified image (sensor_msgs/CameraInfo, P): pixels ``width`` × ``height``, focal length, optical centre."""

    width: int
    height: int
    fx: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.fx + self.cx + self.cy) and self.fx > 0.0):
            raise ConfigError(
                "camera.intrinsics",
                f"A camera's focal length must be positive and its centre finite, not {self.fx}, {self.cx}, {self.cy}.",
            )

    def beams(self) -> tuple[float, float]:
        """Return angle_min and angle_increment, radians, of a scan with one beam for each column of the image."""
        last = math.atan2(self.cx, self.fx)
        first = -math.atan2(self.width - 1 - self.cx, self.fx)
        return first, (last - first) / max(1, self.width - 1)


def cut_depth(depth: NDArray[np.float32], camera: Intrinsics, cut: PlanarCut) -> NDArray[np.float32]:
    """Return the ranges (width,) of the scan that is cut out of a depth image (height, width), metres.

    A beam gets the nearest of its pixels' distances within the cut's range; without one +Inf if a pixel says so, else
    NaN. Beams run counter-clockwise, so the first is at the image's right edge. Raises :class:`ConfigError` for an
    image of another size than the camera's, and for more rows than there are around the optical centre.
    """
    if depth.shape != (camera.height, camera.width):
        raise ConfigError(
            "camera.size",
            f"an image of {depth.shape[1]} × {depth.shape[0]} pixels has a CameraInfo for {camera.width} × "
            f"{camera.height}",
        )
    half = 0.5 * cut.scan_height
    if half > camera.cy or half > camera.height - camera.cy:
        raise ConfigError(
            "camera.rows", f"{cut.scan_height:g} rows around the optical centre are more than the image has"
        )
    top = int(camera.cy - half)
    z = depth[top : top + int(cut.scan_height)].astype(np.float64)
    aside = (np.arange(camera.width) - camera.cx) / camera.fx
    first, step = camera.beams()
    bearing = -np.arctan2(aside, 1.0)
    beam = np.clip(((bearing - first) / step).astype(np.int64) if step > 0.0 else 0, 0, camera.width - 1)
    with np.errstate(invalid="ignore", over="ignore"):
        x = aside * z
        distance = np.where(np.isfinite(z), np.sqrt(x * x + z * z), z)
        least, greatest = cut.depth_range
        counts = (distance >= least) & (distance <= greatest)
    ranges = np.full(camera.width, np.nan, dtype=np.float32)
    beams = np.broadcast_to(beam, z.shape)
    ranges[beams[np.isinf(distance)]] = np.inf
    ranges[beams[counts]] = np.inf
    np.minimum.at(ranges, beams[counts], distance[counts].astype(np.float32))
    return ranges
