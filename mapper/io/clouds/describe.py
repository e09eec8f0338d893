"""Description of a cloud: bounding box, fields, and point spacing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.point_cloud import PointCloud

ASKED = 2000  #: points whose nearest neighbour is searched
MOST_SEARCHED = 500_000  #: points searched; for a larger cloud those of a slab across it


def spacing(points: NDArray[np.floating[Any]]) -> float | None:
    """Return the median distance, metres, from a point to its nearest neighbour; None for fewer than two positions.

    It is computed for up to :data:`ASKED` finite points of ``points`` (n, 3), evenly spaced in their order. Coincident
    points count as one.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415 # only who asks for it pays for it

    if len(points) > MOST_SEARCHED:
        share = MOST_SEARCHED / len(points)
        low, high = np.quantile(points[:, 0], [0.5 - 0.5 * share, 0.5 + 0.5 * share])
        points = points[(points[:, 0] >= low) & (points[:, 0] <= high)][:MOST_SEARCHED]
    places = np.unique(points, axis=0)
    if len(places) < 2:
        return None
    asked = places[:: -(-len(places) // ASKED)]
    distances, _ = cKDTree(places).query(asked, k=2)
    return float(np.median(distances[:, 1]))


@dataclass(frozen=True, slots=True)
class CloudDescription:
    """Facts of a cloud: number of points, number of ``finite`` ones, rows and columns if it is ``organised``.

    ``low`` and ``high`` are the corners of the bounding box of the finite points and ``sensor`` the sensor's position,
    x, y, z in metres. ``fields`` has the dtype and shape of each field.
    """

    points: int
    finite: int
    organised: list[int] | None
    low: list[float] | None
    high: list[float] | None
    spacing_m: float | None
    fields: dict[str, list[str | int]]
    has_times: bool
    sensor: list[float] | None
    notes: list[str]


def description(cloud: PointCloud) -> CloudDescription:
    """Return the facts of a cloud as printed by ``gridbloom info``."""
    known = cloud.points[cloud.finite]
    low, high = (known.min(axis=0), known.max(axis=0)) if len(known) else (None, None)
    return CloudDescription(
        points=len(cloud),
        finite=len(known),
        organised=list(cloud.shape) if cloud.is_organised and cloud.shape else None,
        low=None if low is None else [float(value) for value in low],
        high=None if high is None else [float(value) for value in high],
        spacing_m=spacing(known),
        fields={name: [str(values.dtype), *values.shape[1:]] for name, values in cloud.fields.items()},
        has_times=cloud.times is not None,
        sensor=None if cloud.sensor_pose is None else [float(value) for value in cloud.sensor_pose[:3, 3]],
        notes=list(cloud.notes),
    )
