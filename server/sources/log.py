"""The model of a log session. It plays the log and maps its scans."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import ClassVar

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.grid import OccupancyGrid
from mapper.io.logs.summary import start_s
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.replay.replay import CheckpointPrefetcher
from mapper.sensors.georeference import Offset
from mapper.sensors.joint_log import part_of_scan, sensors_of
from mapper.sensors.scan import ScanLog
from server.parts import parts_of
from server.parts.comparison.part import LogComparison
from server.parts.mapping.part import MappingParameters
from server.sessions.drawings import COLUMN_M, Drawing, Path, Point
from server.sessions.hosting import ModelHost
from server.sessions.model import Footprint, ScanReport, SessionModel, set_robot
from server.sessions.part import ExplainedMap, Offers, Robot
from server.sessions.parts import Graphed
from server.sessions.scene_controls import Choice, SceneControls
from server.sessions.tick import TickResult
from server.sessions.view import LogView, Playback
from server.sources.log_recording import LogRecording
from server.sources.log_updates import FollowedPoses, LogUpdates
from server.sources.map_drawings import map_drawings, sight_of
from server.sources.scene_picks import ScenePick, picked_by
from server.stream.commands import (
    AutoCommand,
    CancelCommand,
    CompareCommand,
    DriveCommand,
    ParametersCommand,
    RestartCommand,
    SeekCommand,
    SensorCommand,
    StepCommand,
    TeleportCommand,
    TrajectoryCommand,
    WorldCommand,
)
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import LogInfo, TrajectoryInfo
from server.stream.messages import FrameMessage, Hello, ParametersMessage, ScanFields, Trajectories
from server.stream.messages import Trajectory as TrajectoryMessage
from server.stream.protocol import ProtocolError, type_of

FILL_S = 30.0  #: the initial speed plays a log in about this many seconds
MAX_GAP_S = 2.0  #: longer gaps between two scans are shortened to this
DEFAULT_GAP_S = 0.1  #: between two scans if all stamps are equal
MAX_PATH_POINTS = 20_000  #: of the trajectory message
SHOWN_EVERY_S = 0.25  #: interval at which a longer seek shows the map in between,
LEAST_SLICE_S = 0.1  #: but not before this much processor time of a thread, so that showing it costs little


def play_times(stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return when each scan is due (n,), in seconds of playback since the first, never decreasing.

    Stamps may decrease, be missing or jump by years. A decrease takes no time, a gap at most :data:`MAX_GAP_S`; a log
    whose stamps never increase plays at :data:`DEFAULT_GAP_S` per scan.
    """
    # Differences as floats, because those of extreme stamps do not fit into 64 bits.
    gaps = np.diff(stamps_ns.astype(np.float64)) * 1e-9
    gaps = np.clip(gaps, 0.0, MAX_GAP_S)
    if not gaps.any():
        gaps = np.full(len(gaps), DEFAULT_GAP_S)
    return np.concatenate([[0.0], np.cumsum(gaps)])


def slice_is_over() -> Callable[[], bool]:
    """Return a function that tells whether this thread has worked for so long that the map should be shown."""
    began, used = time.monotonic(), time.thread_time()
    return lambda: time.monotonic() - began > SHOWN_EVERY_S and time.thread_time() - used > LEAST_SLICE_S


def _playback(times: NDArray[np.float64]) -> Playback:
    """Return the playback of a log whose scans are due at ``times``, with a duration of about :data:`FILL_S`."""
    duration = float(times[-1])
    speeds = (0.1, max(100.0, duration / 5.0))
    return Playback(speed=float(np.clip(float(f"{duration / FILL_S:.2g}"), *speeds)), speeds=speeds)


class LogModel(SessionModel):
    """A log and its map."""

    kind: ClassVar[str] = "log"
    replacing: ClassVar[tuple[type[Struct], ...]] = (
        ParametersCommand,
        SeekCommand,
        RestartCommand,
        TrajectoryCommand,
    )
    resent_on_refusal: ClassVar[Mapping[type[Struct], str]] = {ParametersCommand: "parameters"}

    recording: LogRecording
    comparison: LogComparison

    def __init__(
        self,
        host: ModelHost,
        replay: Replay,
        view: LogView,
        *,
        log_id: str = "",
        title: str = "",
        first: MappingConfig | None = None,
    ) -> None:
        """Map the log up to the scans of ``view``, and pause there. For ``first``, see :class:`LogRecording`."""
        self._times = play_times(replay.log.stamps_ns)
        super().__init__(_playback(self._times))
        replay.may_continue = host.may_continue
        self._host = host
        self._title = title or replay.log.name
        self._time = 0.0  #: seconds of playback
        self._target = 0  #: the index that commands requested
        self._left_at = 0  #: index of the map before the request
        self.recording = self.source = LogRecording(host, replay, log_id, view, first)
        self.parameters = MappingParameters(host, replay.config, self._remake, self._parameters_message)
        self.comparison = LogComparison(host, self.recording, self._parameters_message)
        self._followed = FollowedPoses(self.recording)
        self._updates = LogUpdates(self, self._followed)
        offers = Offers(
            host,
            grid=lambda: self.grid,
            map_title="the log’s own",
            robot=self._robot,
            explained=self._explained,
            recording=self.recording,
            update_log=self._update_log,
        )
        own = (self.parameters, self.comparison, self._updates)
        self.parts = (*own, *parts_of(offers))
        self._report = ScanReport()
        self._map = GridLayer("map", "Map")
        self._map.update(replay.grid, replay.config, None, whole=True)
        if view.index:
            self.playback.playing = False
            self.go_to(min(view.index, replay.log.n_scans))

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The map, and the layers of the parts."""
        of_parts = (layer for part in self.parts_on for layer in part.layers)
        return (self._map, *of_parts)

    @property
    def title(self) -> str:
        """The title of the log."""
        return self._title

    @property
    def frame_id(self) -> str | None:
        """The frame of the poses, None if the log does not state it."""
        return self.recording.log.trajectory(self.recording.trajectory).frame_id

    @property
    def offset(self) -> Offset:
        """The offset of the poses, which is added to the map's origin again."""
        return self.recording.log.trajectory(self.recording.trajectory).offset

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        return self.recording.replay.grid

    @property
    def config(self) -> MappingConfig:
        """The mapping parameters."""
        return self.parameters.config

    @property
    def footprint(self) -> Footprint:
        """Number of cells of both maps, and their logs."""
        return Footprint(
            int(self.grid.log_odds.size) + sum(part.cells for part in self.parts_on),
            (self.recording.log, *(log for part in self.parts_on for log in part.logs)),
        )

    @property
    def fraction(self) -> float | None:
        """Completed share of the current computation."""
        replay, first, last = self.recording.replay, self._left_at, self._target
        if self.is_catching_up and first < replay.index < last:
            return (replay.index - first) / (last - first)
        return replay.fraction

    @property
    def progress(self) -> tuple[int, int]:
        """Number of scans in the map, and of the log."""
        return (self.recording.replay.index, self.recording.log.n_scans)

    def _robot(self) -> Robot:
        """Return the robot at the newest scan in the map."""
        state, number = self.recording.robot_state(), self.recording.replay.index
        topics = [part.topic for part in sensors_of(self.recording.log)]
        topic = topics[part_of_scan(self.recording.log)[max(number - 1, 0)]]
        known = tuple(dict.fromkeys(filter(None, topics)))
        return Robot(state.pose, state.scan.stamp_ns * 1e-9, state.scan, state.scan_pose, number, topic, known)

    def _explained(self) -> list[ExplainedMap]:
        own = ExplainedMap(self._map, self.grid, self.config, self.recording.sources, self.progress[0])
        return [own, *self.comparison.explained()]

    @property
    def _poses(self) -> NDArray[np.float64]:
        """The poses (n, 3) of the scans along the chosen trajectory, ``T_map_base``."""
        return self.recording.log.trajectory(self.recording.trajectory).poses

    def drawings(self) -> list[Drawing]:
        """Return the map, the robot, the path, and what the parts show."""
        return [
            *map_drawings(self.grid, self.recording.robot_state(), self.config),
            Path(name="trajectory", label="Path", poses=self._poses),
            *(drawing for part in self.parts_on for drawing in part.drawings()),
        ]

    def controls(self) -> SceneControls:
        """Return the parameters of the map, the index in the log, and the trajectories if there are several."""
        index, count = self.progress
        names, current = tuple(self.recording.log.trajectories), self.recording.trajectory
        (x0, y0), (x1, y1) = (corner.tolist() for corner in self.recording.replay.bounds)
        return SceneControls(
            playing=self.playback.playing,
            hint="Click the path to go to that scan, a loop or a wall to ask about it.",
            tables=(self.parameters.controls(),),
            choices=(Choice("Trajectory", names, current, TrajectoryCommand),) if len(names) > 1 else (),
            index=index,
            count=count,
            can_restart=True,
            bounds=(x0, y0, x1, y1),
            heights=(0.0, COLUMN_M),
            sight=sight_of(self.recording.robot_state()),
        )

    def on_scene_ray(self, origin: Point, direction: Point, met: Point | None = None) -> Struct:
        """Return the command that determines what was clicked."""
        return ScenePick(origin, direction, met)

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return the prefetcher of missing checkpoints."""
        return self.recording.replay.prefetcher()

    # -- messages -------------------------------------------------------------------------------------------------

    def complete(self, hello: Hello) -> None:
        """Set the parameters, the log and its trajectories."""
        recording, log = self.recording, self.recording.log
        trajectories = self._trajectories_message()
        hello.parameters = self.parameters.table(recording.first_config())
        hello.log = LogInfo(
            id=recording.log_id,
            topic=log.topic,
            cut=recording.cut_table(),
            trajectory=recording.trajectory,
            trajectories=trajectories.trajectories,
            compared=trajectories.compared,
            n_beams=log.n_beams,
            n_scans=log.n_scans,
            duration_s=float(recording.recorded[-1]),
            format=log.format,
            notes=list(log.notes),
            start_s=start_s(log.stamps_ns),
        )

    def messages(self) -> list[Struct]:
        """Return the parameters, the trajectory, and the messages of the parts."""
        return [self._parameters_message(), self._trajectory_message(), *super().messages()]

    def _parameters_message(self) -> ParametersMessage:
        return ParametersMessage(asdict(self.config), None, compare=self.comparison.description())

    def _trajectories_message(self) -> Trajectories:
        trajectories = self.recording.log.trajectories
        same = self.recording.same_paths()
        return Trajectories(
            [
                TrajectoryInfo(name, trajectory.description, trajectory.from_scans, same.get(name))
                for name, trajectory in trajectories.items()
            ],
            self.recording.compared(),
        )

    def _trajectory_message(self) -> TrajectoryMessage:
        recording = self.recording
        trajectory = recording.log.trajectory(recording.trajectory)
        poses = trajectory.poses
        every = -(-len(poses) // MAX_PATH_POINTS)
        path = np.round(poses[::every, :2], 3).tolist()
        stamps = np.round(recording.recorded[::every], 3).tolist()
        return TrajectoryMessage(recording.trajectory, trajectory.frame_id, every, path, stamps)

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the robot's pose at the newest scan."""
        self.parameters.complete_frame(frame)
        set_robot(frame, self.recording.robot_state())

    def scan(self) -> ScanFields:
        """Return the newest scan."""
        return self._report.scan(self.recording.robot_state(), self.config)

    # -- computing ------------------------------------------------------------------------------------------------

    def _remake(self, config: MappingConfig, result: TickResult) -> None:
        self.comparison.remake(self.config, config, result)

    def settle(self, result: TickResult) -> None:
        """Recompute the maps with other parameters, up to the same scan."""
        self.parameters.settle(result)

    def advance(self, dt: float, result: TickResult) -> None:
        """Play, or seek the index that a command requested."""
        replay, playback, count = self.recording.replay, self.playback, self.recording.log.n_scans
        if dt > 0.0 and self._target < count and not self.is_catching_up:
            self._left_at = replay.index
            self._time += dt * playback.speed
            self._target = max(self._target, int(np.searchsorted(self._times, self._time, side="right")))
        if self.is_catching_up:
            try:
                with self._host.cancellable():
                    result.add(replay.advance_to(self._target, slice_is_over()))
            except WorkCancelledError:
                raise
            except MapperError:
                self._target = replay.index
                raise
        if playback.playing and replay.index == count:
            playback.playing = False
            result.changed = True
            result.notice("log.end", "The log has ended: all of its scans are in the map.")

    def draw(self, result: TickResult) -> None:
        """Update the layer of the map, and advance the second map to the same scan."""
        result.changed |= self._map.update(self.grid, self.config, result.box, whole=result.new_grid)
        super().draw(result)

    @property
    def is_catching_up(self) -> bool:
        """Whether the map is not yet at the requested scan."""
        return self._target != self.recording.replay.index

    def play(self) -> None:
        """Play; from the start if the end was reached."""
        self._followed.leave()
        if self.recording.replay.index == self.recording.log.n_scans:
            self.go_to(0)
        super().play()

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command. A seek only sets the target; of several in a tick the last one counts."""
        count = self.recording.log.n_scans
        if isinstance(command, SeekCommand | StepCommand | RestartCommand | CancelCommand | TrajectoryCommand):
            self._followed.leave()
        match command:
            case SeekCommand(index=index):
                if not 0 <= index <= count:
                    raise ProtocolError("command.index", f"The log has {count} scans; there is no map after {index}.")
                is_there = index == self._target
                self.go_to(index)
                if is_there:
                    return
            case ScenePick():
                self._pick(command, result)
            case StepCommand(scans=scans):
                self.playback.playing = False
                self.go_to(min(max(self._target + scans, 0), count))
            case RestartCommand():
                self.go_to(0)
                self.playback.playing = True
            case CancelCommand():
                self.parameters.cancel(result)
                self.playback.playing = False
                self.go_to(self.recording.replay.index)
            case TrajectoryCommand(name=name):
                self.recording.choose(name)
                self._left_at = 0
                result.new_grid = True
                result.slot(self._trajectory_message())
            case CompareCommand():
                raise ProtocolError(
                    "log.compare", "The comparison of a log is set with PUT /api/sessions/{id}/compare."
                )
            case TeleportCommand() | DriveCommand() | AutoCommand() | WorldCommand() | SensorCommand():
                message = f"A log cannot be changed: the command {type_of(command)} is for simulations."
                raise ProtocolError("log.recorded", message)
            case _:
                super().handle(command, result)
                return
        result.changed = True

    def _pick(self, pick: ScenePick, result: TickResult) -> None:
        """Report what was clicked in the 3D view, and go to the scan of a clicked pose."""
        graph = self.find(Graphed)
        picked = picked_by(pick, self._poses, None if graph is None else graph.loops)
        if picked is None:
            return
        result.answer(picked)
        if picked.index is not None:
            self._followed.leave()
            self.go_to(picked.index)

    def _update_log(self, log: ScanLog, result: TickResult) -> None:
        self.updated(result, is_new=self.recording.update(log))

    def updated(self, result: TickResult, *, is_new: bool) -> None:
        """Continue after the log got other trajectories. ``is_new`` says whether the map was restarted."""
        if is_new:
            self._left_at = 0
            result.new_grid = True
        self.comparison.update_log(self.recording.log)
        result.slot(self._trajectories_message())
        result.slot(self._trajectory_message())

    def use_sensor(self, log: ScanLog, view: LogView, result: TickResult) -> None:
        """Restart the map with another sensor of the log, or with other options for cutting scans.

        It is mapped up to the same time.
        """
        recording = self.recording
        stamps, index = recording.log.stamps_ns, recording.replay.index
        reached = None if index == recording.log.n_scans else stamps[:index].max(initial=stamps.min() - 1)
        recording.use(log, view)
        self.comparison.end(result)
        for part in self.parts:
            part.forget()
        self._followed.leave()
        self.parameters.adopt(recording.replay.config)
        self._times = play_times(log.stamps_ns)
        self.go_to(log.n_scans if reached is None else int((log.stamps_ns <= reached).sum()))
        self._left_at = 0
        result.is_new_hello = result.new_grid = True
        for message in (*self.messages(), self._trajectories_message()):
            result.slot(message)

    def go_to(self, index: int) -> None:
        """Request a map of this number of scans."""
        self._left_at = self.recording.replay.index
        self._target = index
        self._time = float(self._times[max(index - 1, 0)])
