"""Planar scan from a depth image: the nearest pixel of some rows in each direction.

Source: the ROS package depthimage_to_laserscan and its pinhole model: the pixel (u, v) with depth z is the point x = (u
− cx) z / fx to the right of the optical axis. The camera is assumed to be level.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.sensors.camera import Intrinsics
from mapper.sensors.planar.options import PlanarCut


def cut_depth(depth: NDArray[np.float32], camera: Intrinsics, cut: PlanarCut) -> NDArray[np.float32]:
    """Return the ranges (width,) of the scan extracted from a depth image (height, width), metres.

    A beam is the nearest of its pixels' distances within the cut's range; otherwise +Inf if a pixel is +Inf, else NaN.
    Beams run counter-clockwise, so the first is at the image's right edge. Raises :class:`ConfigError` for an image of
    another size than the camera's, and for more rows than there are around the optical centre.
    """
    camera.check_size(depth, "a CameraInfo")
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
