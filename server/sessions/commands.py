"""Commands that the service itself sends to a session. No client can send them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from msgspec import Struct

from server.sessions.drawings import Point

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from mapper.sensors.scan import ScanLog
    from server.library.packs.filter_states import FilterStates
    from server.library.packs.reference_map import ReferenceMap
    from server.library.processing.localization import LocalizeProgress
    from server.sessions.parts import UploadedCosts
    from server.sessions.view import LogView


class UpdateLog(Struct):
    """Use the log with other trajectories."""

    log: ScanLog


class UseSensor(Struct):
    """Restart the map with another sensor of the log, or with other options for cutting scans."""

    log: ScanLog
    view: LogView


class FollowPoses(Struct):
    """Show the map along the poses that a job is computing, as the trajectory ``name``."""

    name: str


class PosesSoFar(Struct):
    """The poses (n, 3) that the job has computed so far, and localization's ``report``.

    ``is_known`` (n,) is False for poses that are not known yet; None if all are known.
    """

    poses: NDArray[np.float64]
    is_known: NDArray[np.bool_] | None = None
    report: LocalizeProgress | None = None


class PosesEnded(Struct):
    """The job has ended. ``name`` is the trajectory that it produced, None if there is none."""

    trajectory: str | None


class ShowReferenceMap(Struct):
    """Show the map in which the log was localized."""

    map: ReferenceMap


class ShowFilterStates(Struct):
    """Show the uncertainty of the filter along a trajectory."""

    trajectory: str
    states: FilterStates


class UseTerrain(Struct, tag_field="type", tag="use_terrain"):
    """:class:`UseCosts` as the history of a session records it: ``log`` is the upload that has the costs."""

    log: str


class UseCosts(Struct):
    """Use the costs of an upload for a layer of the costmap; None removes them."""

    costs: UploadedCosts | None


class MeasureRay(Struct):
    """A click in the 3D view of a page that measures. Only the service sends it.

    The line of sight starts at ``origin`` and has the given ``direction``. It ends at ``met`` on a column of the map,
    in map metres; None if it meets no column.
    """

    origin: Point
    direction: Point
    met: Point | None


def on_floor(origin: Point, direction: Point) -> tuple[float, float] | None:
    """Return where a line of sight meets the floor: x and y in metres, None if it does not."""
    (ox, oy, oz), (dx, dy, dz) = origin, direction
    if dz * oz >= 0.0:
        return None
    x, y = ox - dx * oz / dz, oy - dy * oz / dz
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
