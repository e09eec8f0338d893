"""The commands of the service itself to a session, which no client can send."""

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
    """The log has other trajectories."""

    log: ScanLog


class UseSensor(Struct):
    """Begin the map again of another sensor of the log, or of scans that are cut otherwise."""

    log: ScanLog
    view: LogView


class FollowPoses(Struct):
    """Show the map along the poses that a job makes, as the trajectory ``name``."""

    name: str


class PosesSoFar(Struct):
    """The poses (n, 3) that the job has made so far; ``report`` is what localization says besides.

    ``is_known`` (n,) is False where a pose is not known yet, None: all are.
    """

    poses: NDArray[np.float64]
    is_known: NDArray[np.bool_] | None = None
    report: LocalizeProgress | None = None


class PosesEnded(Struct):
    """The job has ended with a trajectory of this name, None for none."""

    trajectory: str | None


class ShowReferenceMap(Struct):
    """The log is localized in this map."""

    map: ReferenceMap


class ShowFilterStates(Struct):
    """How certain the filter was along a trajectory."""

    trajectory: str
    states: FilterStates


class UseTerrain(Struct, tag_field="type", tag="use_terrain"):
    """As the history of a session has :class:`UseCosts`: the upload ``log`` has the costs."""

    log: str


class UseCosts(Struct):
    """Take the costs of an upload for a layer of the costmap; None for none."""

    costs: UploadedCosts | None


class MeasureRay(Struct):
    """A click into the 3D view of a page that measures, which only the service sends.

    Its line of sight goes from ``origin`` along ``direction``, and ends at ``met`` on a column of the map, map metres;
    None: it meets none.
    """

    origin: Point
    direction: Point
    met: Point | None


def on_floor(origin: Point, direction: Point) -> tuple[float, float] | None:
    """Return where a line of sight comes down (or up) to the floor, x and y, metres; None: nowhere."""
    (ox, oy, oz), (dx, dy, dz) = origin, direction
    if dz * oz >= 0.0:
        return None
    x, y = ox - dx * oz / dz, oy - dy * oz / dz
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
