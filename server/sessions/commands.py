"""The commands of the service itself to a session, which no client can send."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec import Struct

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
