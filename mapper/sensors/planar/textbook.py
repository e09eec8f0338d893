"""Planar scans from clouds and depth images, point by point, as in the ROS packages."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.camera import Intrinsics
from mapper.sensors.planar.cloud import Placement
from mapper.sensors.planar.options import PlanarCut


def cut_cloud(points: NDArray[np.float64], placement: Placement, cut: PlanarCut) -> NDArray[np.float32]:
    """Return the ranges (n_beams,) that :func:`mapper.sensors.planar.cloud.add_points` computes from points."""
    ranges = np.full(cut.n_beams, np.nan, dtype=np.float32)
    r, t = placement.rotation.tolist(), placement.translation.tolist()
    for px, py, pz in points.tolist():
        x = r[0][0] * px + r[0][1] * py + r[0][2] * pz
        y = r[1][0] * px + r[1][1] * py + r[1][2] * pz
        z = r[2][0] * px + r[2][1] * py + r[2][2] * pz + t[2]
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            continue
        angle = float(np.arctan2(y, x))
        if angle < cut.angle_min or angle > cut.angle_max:
            continue
        index = min(int((angle - cut.angle_min) / cut.angle_increment), cut.n_beams - 1)
        if math.isnan(ranges[index]):
            ranges[index] = math.inf
        if z < cut.min_height or z > cut.max_height:
            continue
        distance = math.sqrt(x * x + y * y)
        if distance < cut.cloud_range[0] or distance > cut.cloud_range[1]:
            continue
        ranges[index] = min(ranges[index], np.float32(distance))
    return ranges


def cut_depth(depth: NDArray[np.float32], camera: Intrinsics, cut: PlanarCut) -> NDArray[np.float32]:
    """Return the ranges (width,) that :func:`mapper.sensors.planar.depth.cut_depth` computes from an image (height,
    width).

    Works pixel by pixel, with depthimage_to_laserscan's rule for choosing between two readings (``use_point``).
    """
    ranges = np.full(camera.width, np.nan, dtype=np.float32)
    first, step = camera.beams()
    top = int(camera.cy - cut.scan_height / 2)
    for v in range(top, top + int(cut.scan_height)):
        for u in range(camera.width):
            z = float(depth[v, u])
            aside = (u - camera.cx) / camera.fx
            angle = -float(np.arctan2(aside, 1.0))
            index = min(max(int((angle - first) / step), 0), camera.width - 1) if step > 0.0 else 0
            new = math.sqrt(aside * z * (aside * z) + z * z) if math.isfinite(z) else z
            if _use_point(new, float(ranges[index]), cut.depth_range):
                ranges[index] = new
    return ranges


def _use_point(new: float, old: float, limits: tuple[float, float]) -> bool:
    if not math.isfinite(new) and not math.isfinite(old):
        return not math.isnan(new)  # +Inf is preferred to NaN
    if not limits[0] <= new <= limits[1]:
        return False
    return not math.isfinite(old) or new < old
