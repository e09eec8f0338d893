"""The model of a session: the interface that every kind of session implements.

Methods run on a worker thread unless stated otherwise. The event loop reads what a model shows between two ticks. A
model uses no sockets and no asyncio, only its :class:`server.sessions.hosting.ModelHost`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

import msgspec
import numpy as np
from msgspec import UNSET, Struct

from mapper.core.kernels.decimals import MOST_BYTES, TOO_LARGE, write_thousandths
from mapper.grid import OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.georeference import NO_OFFSET, Offset
from mapper.sensors.scan import RangeScan, ScanLog, SonarScan
from server.sessions.commands import MeasureRay, on_floor
from server.sessions.drawings import Drawing, Point, Quaternion
from server.sessions.parts import Volumetric
from server.sessions.scene_controls import SceneControls
from server.sessions.tick import TickResult
from server.sessions.view import Playback, Pose, RobotState
from server.stream.layers import Layer
from server.stream.message_parts import Parameter
from server.stream.messages import FrameMessage, Hello, PlaceMessage, ScanFields
from server.stream.protocol import ProtocolError, type_of

if TYPE_CHECKING:
    from mapper.replay.replay import CheckpointPrefetcher
    from server.sessions.part import Part

T = TypeVar("T")
NO_SCAN = ScanFields()
#: Without readings, pages would wait for a first scan.
NO_READINGS = ScanFields(scan_pose=(0.0, 0.0, 0.0), ranges=[], angle_min=0.0, angle_increment=0.0, range_max=0.0)


@dataclass(frozen=True, slots=True)
class Footprint:
    """Memory that a model uses: cells of its grids, and logs."""

    cells: int = 0
    logs: tuple[ScanLog, ...] = ()


class SessionModel(ABC):
    """Model of a session. A kind must implement :attr:`layers` and :meth:`advance`; the rest has defaults."""

    kind: ClassVar[str]  #: name of the kind, as in :data:`server.sources.KINDS`
    replacing: ClassVar[tuple[type[Struct], ...]] = ()
    """Commands that make an unfinished map useless."""
    resent_on_refusal: ClassVar[Mapping[type[Struct], str]] = {}
    """Command → type of the message that is resent to its sender if the command is refused."""

    source: object = None  #: what its parts work on, if that is a separate object
    parts: Sequence[Part] = ()  #: its capabilities, in the order in which changes are passed to them

    def __init__(self, playback: Playback | None = None) -> None:
        self.playback = playback or Playback()
        self._subject = "map"

    # -- required -------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def layers(self) -> Sequence[Layer]:
        """The displayed layers, the map first."""

    @abstractmethod
    def advance(self, dt: float, result: TickResult) -> None:
        """Advance by ``dt`` seconds; 0 only completes what commands started.

        Raises :class:`mapper.core.errors.WorkCancelledError` if a newer command cancelled it, and
        :class:`mapper.core.errors.MapperError` if it cannot continue; the session is then paused.
        """

    def find(self, kind: type[T]) -> T | None:
        """Return the implementation of an interface: the model, its source or one of its parts; None if none has it."""
        return next((provider for provider in (self, self.source, *self.parts) if isinstance(provider, kind)), None)

    @property
    def parts_on(self) -> list[Part]:
        """The parts that are on, or follow a part that is on."""
        return [part for part in self.parts if part.is_on or (part.followed is not None and part.followed.is_on)]

    # -- description -----------------------------------------------------------------------------------------------

    @property
    def title(self) -> str:
        """The title that pages show."""
        return self.kind.capitalize()

    @property
    def file_stem(self) -> str:
        """The stem of the names of downloaded files."""
        return self.title

    @property
    def frame_id(self) -> str | None:
        """The frame of the map, None if unknown."""
        return "map"

    @property
    def offset(self) -> Offset:
        """What to add to map coordinates to get those in :attr:`frame_id`: x and y, metres."""
        return NO_OFFSET

    @property
    def grid(self) -> OccupancyGrid | None:
        """The map for download, None if there is none."""
        return None

    @property
    def footprint(self) -> Footprint:
        """The memory that the model uses (any thread)."""
        return Footprint()

    @property
    def progress(self) -> tuple[int, int]:
        """``(index, count)``: number of scans in the map, and in total."""
        return (0, 0)

    def complete(self, hello: Hello) -> None:  # noqa: B027 - some kinds have none
        """Set the fields of ``hello`` specific to the kind. By default there are none."""

    def tables(self) -> dict[str, list[Parameter]]:
        """Return the parameter rows of the parts, by the type of the command that sets them."""
        return {command: rows for part in self.parts for command, rows in part.tables.items()}

    def messages(self) -> list[Struct]:
        """Return the messages for a new client, the newest of each type; by default those of the parts."""
        return [message for part in self.parts for message in part.messages()]

    def history(self) -> list[Struct]:
        """Return the commands that bring the parts of another session to the same state."""
        return [command for part in self.parts for command in part.history()]

    def complete_frame(self, frame: FrameMessage) -> None:  # noqa: B027 - some kinds have none
        """Set the fields of ``frame`` specific to the kind, except those about the scan."""

    def scan(self) -> ScanFields:
        """Return the fields of ``frame`` about the newest scan; the same object until there is a newer scan."""
        return NO_SCAN

    # -- 3D -------------------------------------------------------------------------------------------------------

    def drawings(self) -> list[Drawing]:
        """Return the drawings of the 3D view (event loop, between two ticks); ticks may update their arrays."""
        return []

    def controls(self) -> SceneControls:
        """Return the controls of the 3D view's panel (event loop, between two ticks)."""
        return SceneControls(playing=self.playback.playing)

    def on_scene_click(self, x: float, y: float) -> Struct | None:  # noqa: ARG002 - most kinds need none
        """Return the command for a click on the floor of the 3D view at (x, y), metres; None for no command.

        Event loop, possibly during a tick: read only attributes that a tick replaces as a whole.
        """
        return None

    def on_scene_ray(
        self,
        origin: Point,
        direction: Point,
        met: Point | None = None,  # noqa: ARG002 - most kinds need none
    ) -> Struct | None:
        """Return the command for a click whose ray in the 3D view begins at ``origin``, metres; None for none.

        ``met`` is where the ray meets the columns of a displayed map, None if it does not. By default this is the
        command for the voxel that the ray meets, if there is a 3D map that answers clicks, else the one for a click on
        the floor where the ray meets it. Called like :meth:`on_scene_click`.
        """
        volume = self.find(Volumetric)
        if volume is not None and volume.is_on and volume.is_asked:
            return volume.question(origin, direction)
        place = on_floor(origin, direction)
        return None if place is None else self.on_scene_click(*place)

    def on_gizmo_moved(
        self,
        name: str,
        position: Point,
        wxyz: Quaternion,  # noqa: ARG002 - a clip box has none
    ) -> Struct | None:
        """Return the command for a move of the gizmo ``name``, None for no command. Called like :meth:`on_scene_click`.

        By default this is the command for a handle of a 3D map's clip box.
        """
        volume = self.find(Volumetric)
        return volume.clipped(name, position) if volume is not None and volume.is_on else None

    # -- commands -------------------------------------------------------------------------------------------------

    def play(self) -> None:
        """Start playing."""
        self.playback.playing = True

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command other than those of every session (play, pause, speed). By default a part handles it.

        Sets ``result.changed`` if a new frame must be published. If the command is refused, raises
        :class:`ProtocolError` or :class:`mapper.core.errors.MapperError` and changes nothing.
        """
        if isinstance(command, MeasureRay):
            self._answer_place(command, result)
            return
        for part in self.parts:
            if isinstance(command, part.commands):
                with self.computing(part.subject):
                    part.handle(command, result)
                return
        raise ProtocolError("command.unknown", f"A {self.kind} session has no command {type_of(command)!r:.80}.")

    def _answer_place(self, ray: MeasureRay, result: TickResult) -> None:
        """Answer a measuring page's click with the place that it selects; with none if it meets nothing."""
        volume = self.find(Volumetric)
        met = volume.met(ray.origin, ray.direction) if volume is not None and volume.is_on else None
        if met is not None:
            (x, y, z), size = met
            result.answer(PlaceMessage(x, y, z, size))
        elif (place := ray.met or on_floor(ray.origin, ray.direction)) is not None:
            result.answer(PlaceMessage(place[0], place[1], None, None))

    def settle(self, result: TickResult) -> None:  # noqa: B027 - most kinds need none
        """Compute what the commands of this tick requested, such as a map with other parameters, once for all."""

    def draw(self, result: TickResult) -> None:
        """Update the layers with the changes of the tick; by default the layers of the parts."""
        for part in self.parts_on:
            with self.computing(part.subject):
                part.changed(result)

    # -- long work ------------------------------------------------------------------------------------------------

    @property
    def is_catching_up(self) -> bool:
        """Whether the maps are not up to date with the commands, so that the next tick continues (event loop)."""
        return False

    @property
    def catch_up_pause_s(self) -> float:
        """Seconds for which a tick that only catches up waits, so that earlier results are sent first."""
        return 0.0

    @property
    def fraction(self) -> float | None:
        """Completed share of the current computation, 0 to 1; None if unknown (any thread)."""
        return None

    @property
    def working_on(self) -> str:
        """Subject of the current computation, as in the ``working`` message (any thread)."""
        return next((part.answering for part in self.parts if part.answering), self._subject)

    @contextmanager
    def computing(self, subject: str) -> Iterator[None]:
        """Return a context in which :attr:`working_on` is ``subject``."""
        before, self._subject = self._subject, subject
        try:
            yield
        finally:
            self._subject = before

    @property
    def has_deferred_work(self) -> bool:
        """Whether there is work that the layers do not depend on (event loop). By default a part has it."""
        return any(part.has_deferred_work for part in self.parts_on)

    def run_deferred_work(self, result: TickResult) -> None:
        """Do the deferred work."""
        for part in self.parts_on:
            part.run_deferred_work(result)

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return the prefetcher of checkpoints, None if no checkpoint is missing (event loop)."""
        return None


def set_robot(frame: FrameMessage, robot_state: RobotState) -> None:
    """Set the fields of a ``frame`` message about the robot's pose."""
    frame.stamp = round(robot_state.stamp_s, 4)
    frame.pose = _rounded(robot_state.pose)
    frame.sensor_pose = _rounded(robot_state.sensor_pose)
    if robot_state.believed_pose is not None:
        frame.believed_pose = _rounded(robot_state.believed_pose)


def scan_of(robot_state: RobotState, config: MappingConfig) -> ScanFields:
    """Return the fields of a ``frame`` message about the robot's scan."""
    scan, believed = robot_state.scan, robot_state.believed_scan_pose
    return ScanFields(
        scan_pose=_rounded(robot_state.scan_pose),
        believed_scan_pose=UNSET if believed is None else _rounded(believed),
        ranges=_ranges(scan),
        angle_min=0.0 if isinstance(scan, SonarScan) else scan.angle_min,
        angle_increment=0.0 if isinstance(scan, SonarScan) else scan.angle_increment,
        bearings=np.round(scan.bearings, 5).tolist() if isinstance(scan, SonarScan) else UNSET,
        beam_width=scan.beam_width if scan.beam_width > 0.0 else UNSET,
        range_max=min(scan.range_max, config.range_max),
    )


class ScanReport:
    """The fields of ``frame`` about a scan, computed once per scan."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._scan = NO_READINGS

    def scan(self, robot: RobotState, config: MappingConfig) -> ScanFields:
        """Return the fields of the newest scan; the same object until there is a newer scan."""
        key = (robot.scan, robot.scan_pose, robot.believed_scan_pose, config.range_max)
        if not self._key or self._key[0] is not robot.scan or self._key[1:] != key[1:]:
            self._key, self._scan = key, scan_of(robot, config)
        return self._scan


def _rounded(pose: Pose) -> Pose:
    x, y, yaw = (round(value, 4) for value in pose)
    return (x, y, yaw)


def _ranges(scan: RangeScan) -> list[float | None]:
    """Return :func:`readings` as JSON for the encoder to copy, if no value is too large for that."""
    text = np.empty(2 + MOST_BYTES * len(scan.ranges), dtype=np.uint8)
    low, high = (float(np.float32(limit)) for limit in (scan.range_min, scan.range_max))  # as NumPy compares them
    size = write_thousandths(scan.ranges, low, high, text)
    return readings(scan) if size == TOO_LARGE else cast("list[float | None]", msgspec.Raw(text[:size].tobytes()))


def readings(scan: RangeScan) -> list[float | None]:
    """Return the scan's readings in metres, rounded; None for no return and for invalid readings."""
    ranges = scan.ranges
    measured = (ranges >= scan.range_min) & (ranges <= scan.range_max) & np.isfinite(ranges)
    rounded: list[float | None] = np.round(ranges.astype(np.float64), 3).tolist()
    for i in np.flatnonzero(~measured).tolist():
        rounded[i] = None
    return rounded
