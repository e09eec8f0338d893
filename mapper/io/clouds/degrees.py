"""Conversion of points in degrees of longitude and latitude to metres in a plane.

Source: the radii of curvature of the ellipsoid WGS 84, in the meridian M and in the prime vertical N; NIMA TR8350.2.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ReadError

SEMI_MAJOR_M, ECCENTRICITY_2 = 6378137.0, 6.69437999014e-3  #: of WGS 84
WIDEST = 1.0  #: degrees: a tangent plane of the ellipsoid is not useful for a wider cloud
MOST = (180.0, 90.0)  #: longitude and latitude
FINE_DEGREES = 2e-6  #: resolution of coordinates below which, with coarse heights, they are not metres


def have_steps_of_degrees(points: NDArray[np.float64], steps: Sequence[float]) -> bool:
    """Return whether points (n, 3) may be longitude, latitude and height, by the ``steps`` of their coordinates.

    Coordinates in metres would not be a million times finer than a metre with heights a hundred times coarser.
    """
    most = np.nanmax(np.abs(points[:, :2]), axis=0, initial=0.0)
    return bool(max(steps[:2]) <= FINE_DEGREES and steps[2] >= 100.0 * max(steps[:2]) and (most <= MOST).all())


def metres_of_degrees(lon_lat: NDArray[np.float64], why: str) -> tuple[NDArray[np.float64], str]:
    """Return points (n, 2) of longitude and latitude, degrees, as metres east and north of an origin, and a note.

    The origin is the middle of the points, rounded to a millionth of a degree; ``why`` is the beginning of the note.
    The plane is tangent to the ellipsoid there, so distances have errors of up to a hundredth in a cloud of 100 km.
    Points beyond ±180° and ±90° cannot be degrees, even if stated so, and are returned unchanged, with a note. Raises
    :class:`ReadError` for clouds wider than :data:`WIDEST`.
    """
    known = lon_lat[np.isfinite(lon_lat).all(axis=1)]
    if len(known) == 0:
        return lon_lat, why
    low, high = known.min(axis=0), known.max(axis=0)
    box = f"{low[0]:g} to {high[0]:g} and {low[1]:g} to {high[1]:g}"
    if (np.maximum(-low, high) > MOST).any():
        return lon_lat, f"{why}, but they are {box}, which no degrees are: they are taken as metres."
    if (high - low > WIDEST).any():
        raise ReadError(
            "cloud.degrees",
            f"{why}, and they are {box}: a plane can hold at most {WIDEST:g}°. Project the cloud, for "
            "example to UTM, in metres.",
        )
    place = np.round(0.5 * (low + high), 6)
    latitude = np.radians(place[1])
    w2 = 1.0 - ECCENTRICITY_2 * np.sin(latitude) ** 2
    meridian = SEMI_MAJOR_M * (1.0 - ECCENTRICITY_2) / w2**1.5
    across = SEMI_MAJOR_M / np.sqrt(w2) * np.cos(latitude)
    points = np.radians(lon_lat - place) * (across, meridian)
    return points, f"{why}: x and y are metres east and north of {place[0]:.6f}°, {place[1]:.6f}° here (WGS 84)."
