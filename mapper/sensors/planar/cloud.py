"""Planar scan from a point cloud: the nearest point of a height band in each direction.

The beams of a tilting sensor are converted to points and treated as a cloud.

Source: the ROS package pointcloud_to_laserscan, with two differences. Ranges are measured from the sensor's position
seen from above, not from the target frame's origin, because its rays start there. A direction without any point is NaN,
while that package reports "no return" (+Inf).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.planar.options import PlanarCut


@dataclass(frozen=True, slots=True)
class Placement:
    """Pose of a cloud's frame in the robot's base frame: ``rotation`` (3, 3), ``translation`` (3,) metres."""

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    @property
    def mount(self) -> tuple[float, float, float]:
        """``T_base_scan`` (m, m, rad) of the extracted scans: at the sensor's position, parallel to the base's axes."""
        return (float(self.translation[0]), float(self.translation[1]), 0.0)


NOT_PLACED = Placement(np.eye(3), np.zeros(3))


def empty_scan(cut: PlanarCut) -> NDArray[np.float32]:
    """Return the ranges (n_beams,) of a scan without points: NaN."""
    return np.full(cut.n_beams, np.nan, dtype=np.float32)


def first_beam(cut: PlanarCut) -> float:
    """Return the bearing of the first beam, radians: the middle of its sector."""
    return cut.angle_min + 0.5 * cut.angle_increment


def add_points(points: NDArray[np.float64], placement: Placement, cut: PlanarCut, ranges: NDArray[np.float32]) -> None:
    """Add points (n, 3) of a cloud, metres in its frame, to the ``ranges`` (n_beams,) of its scan.

    Each beam is the horizontal distance of the nearest point of its sector with height (in the base frame) and distance
    within the limits of ``cut``; +Inf if its sector has only other points. Non-finite points are ignored.
    """
    (rx, ry, rz), t = placement.rotation, placement.translation
    px, py, pz = points.T
    least, greatest = cut.cloud_range
    with np.errstate(invalid="ignore", over="ignore"):
        x = rx[0] * px + rx[1] * py + rx[2] * pz
        y = ry[0] * px + ry[1] * py + ry[2] * pz
        height = rz[0] * px + rz[1] * py + rz[2] * pz + t[2]
        distance = np.sqrt(x * x + y * y)
        bearing = np.arctan2(y, x)
        seen = np.isfinite(x) & np.isfinite(y) & np.isfinite(height)
        seen &= (bearing >= cut.angle_min) & (bearing <= cut.angle_max)
        counts = seen & (height >= cut.min_height) & (height <= cut.max_height)
        counts &= (distance >= least) & (distance <= greatest)
        nearest = distance[counts].astype(np.float32)
    beam = np.zeros(len(points), dtype=np.int64)
    beam[seen] = np.minimum((bearing[seen] - cut.angle_min) / cut.angle_increment, cut.n_beams - 1)
    sectors = beam[seen]
    ranges[sectors[np.isnan(ranges[sectors])]] = np.inf
    np.minimum.at(ranges, beam[counts], nearest)


def cut_tilted(
    ranges: NDArray[np.float32],
    bearings: NDArray[np.float64],
    limits: tuple[float, float],
    rotations: NDArray[np.float64],
    translations: NDArray[np.float64],
    cut: PlanarCut,
) -> NDArray[np.float32]:
    """Return level scans (n, cut.n_beams) of a sensor whose pose in the base frame differs between n scans.

    ``ranges`` (n, n_beams) metres with ``bearings`` (n_beams,) radians in the sensor's plane; those outside ``limits``
    are ignored. ``rotations`` (n, 3, 3) and ``translations`` (n, 3) are ``T_base_sensor``. Each scan is the result of
    :func:`mapper.sensors.planar.cloud.add_points` for the endpoints of its beams. A beam without return contributes
    nothing, because the height at which it passed obstacles is not known.
    """
    out = np.tile(empty_scan(cut), (len(ranges), 1))
    rays = np.stack([np.cos(bearings), np.sin(bearings), np.zeros(len(bearings))], axis=1)
    least, greatest = limits
    for row, scan in enumerate(ranges.astype(np.float64)):
        measured = (scan >= least) & (scan <= greatest) & np.isfinite(scan)
        points = scan[measured, np.newaxis] * rays[measured]
        add_points(points, Placement(rotations[row], translations[row]), cut, out[row])
    return out
