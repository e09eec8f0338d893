"""Level scans cut out of those of a planar sensor that tilts: its beams end at points, which are cut as a cloud's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.planar.cloud import Placement, add_points, empty_scan
from mapper.sensors.planar.options import PlanarCut


def cut_tilted(
    ranges: NDArray[np.float32],
    bearings: NDArray[np.float64],
    limits: tuple[float, float],
    rotations: NDArray[np.float64],
    translations: NDArray[np.float64],
    cut: PlanarCut,
) -> NDArray[np.float32]:
    """Return level scans (n, cut.n_beams) of a sensor that was at other poses in the base frame at each of n scans.

    ``ranges`` (n, n_beams) metres with ``bearings`` (n_beams,) radians in the sensor's plane; those outside ``limits``
    are no points. ``rotations`` (n, 3, 3) and ``translations`` (n, 3) are ``T_base_sensor``. Each scan is what
    :func:`mapper.sensors.planar.cloud.add_points` makes of the points where its beams ended; a beam without a return
    says nothing, for what it passed above is not known.
    """
    out = np.tile(empty_scan(cut), (len(ranges), 1))
    rays = np.stack([np.cos(bearings), np.sin(bearings), np.zeros(len(bearings))], axis=1)
    least, greatest = limits
    for row, scan in enumerate(ranges.astype(np.float64)):
        measured = (scan >= least) & (scan <= greatest) & np.isfinite(scan)
        points = scan[measured, np.newaxis] * rays[measured]
        add_points(points, Placement(rotations[row], translations[row]), cut, out[row])
    return out
