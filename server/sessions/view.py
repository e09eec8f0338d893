"""Values that sessions and their users exchange: poses, views, playback, requests for a comparison."""

from __future__ import annotations

from dataclasses import dataclass, field

from mapper.core.parameter import Values
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import RangeScan, ScanLog
from server.stream.protocol import ProtocolError

Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class LogView:
    """The view of a log, which another session can reproduce.

    It consists of the sensor and the trajectory (None: the default), the parameter values, the number of scans in the
    map, and the options for cutting scans out of clouds and depth images, values of
    :data:`mapper.sensors.planar.options.PARAMETERS`.
    """

    topic: str | None = None
    trajectory: str | None = None
    values: Values | None = None
    index: int = 0
    cut: dict[str, float] | None = None

    @property
    def planar_cut(self) -> PlanarCut:
        """Options for cutting scans out of clouds and depth images. Raises :class:`mapper.core.errors.ConfigError`."""
        return PlanarCut.of(self.cut or {})


@dataclass(frozen=True, slots=True)
class MapRequest:
    """A requested map to compare with: the map of ``log`` (None: the session's own) along the poses of ``trajectory``.

    ``values`` are the parameters set for that map; all others are the session's.
    """

    values: Values = field(default_factory=dict)
    trajectory: str | None = None
    log: ScanLog | None = None
    log_id: str | None = None
    topic: str | None = None
    title: str = ""


@dataclass(frozen=True, slots=True)
class GraphChange:
    """A manual change of a pose graph; fields that are None change nothing.

    ``remove``, ``lock`` and ``unlock`` are numbers of loops, ``add`` two scans to be joined by a loop. ``robust`` and
    ``robust_scale`` select how the graph is solved. ``reset`` restores the result of SLAM.
    """

    remove: int | None = None
    lock: int | None = None
    unlock: int | None = None
    add: tuple[int, int] | None = None
    robust: str | None = None
    robust_scale: float | None = None
    reset: bool = False


@dataclass(frozen=True, slots=True)
class RobotState:
    """The robot and its newest scan.

    ``pose`` is T_map_base and ``sensor_pose`` T_map_laser now, ``scan_pose`` is T_map_laser at the scan. None of them
    includes the mount correction of the parameters, which is composed onto them in the map. ``believed_*`` are the
    robot's estimates of them, None if they are exact.
    """

    pose: Pose
    sensor_pose: Pose
    scan_pose: Pose
    scan: RangeScan
    stamp_s: float
    believed_pose: Pose | None = None
    believed_scan_pose: Pose | None = None


@dataclass(slots=True)
class Playback:
    """Whether a session plays. ``speed`` is session time per second of real time, within ``speeds``."""

    playing: bool = True
    speed: float = 1.0
    speeds: tuple[float, float] = (0.25, 8.0)  #: the least and the greatest speed

    def set_speed(self, speed: float) -> None:
        """Set the speed. Raises :class:`ProtocolError` if it is outside ``speeds``."""
        low, high = self.speeds
        if not low <= speed <= high:
            raise ProtocolError("command.value", f"The speed must be between {low:g} and {high:g}.")
        self.speed = speed
