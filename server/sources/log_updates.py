"""Commands of the service to a log session, which no client can send: other trajectories, another sensor, a job."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from msgspec import Struct

from mapper.core.errors import MapperError
from mapper.sensors.scan import ScanLog
from server.sessions.commands import (
    FollowPoses,
    PosesEnded,
    PosesSoFar,
    UpdateLog,
    UseSensor,
)
from server.sessions.part import Part
from server.sessions.playback import Playback
from server.sessions.tick import TickResult, error_message
from server.sessions.view import LogView
from server.sources.log_healing import LogHealing
from server.sources.log_recording import LogRecording


class Updated(Protocol):
    """The model of a log session, as far as it is updated."""

    recording: LogRecording
    parts: Sequence[Part]
    playback: Playback

    @property
    def is_catching_up(self) -> bool:
        """Whether the map is not yet that of the requested scan."""

    def go_to(self, index: int) -> None:
        """Have the map brought to a number of scans."""

    def use_sensor(self, log: ScanLog, view: LogView, result: TickResult) -> None:
        """Begin the map again of another sensor of the log, or of scans that are cut otherwise."""

    def updated(self, result: TickResult, *, is_new: bool) -> None:
        """Go on after the log got other trajectories; ``is_new`` says whether the map was begun again."""


class LogUpdates(Part):
    """Carries them out on a worker thread."""

    commands = (
        UpdateLog,
        UseSensor,
        FollowPoses,
        PosesSoFar,
        PosesEnded,
    )

    def __init__(self, model: Updated, healing: LogHealing) -> None:
        self._model, self._healing = model, healing

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command of the service."""
        model = self._model
        match command:
            case UpdateLog(log=log):
                model.updated(result, is_new=model.recording.update(log))
            case UseSensor(log=log, view=view):
                try:
                    model.use_sensor(log, view, result)
                except MapperError as error:
                    result.notices.append(error_message(error.code, error.message))
            case FollowPoses(name=name):
                self._healing.begin(name)
            case PosesSoFar():
                self._show_poses(command, result)
            case PosesEnded(trajectory=trajectory):
                self._tell(command, result)
                self._end_poses(trajectory, result)
        result.changed = True

    def _tell(self, command: Struct, result: TickResult) -> None:
        """Have the other parts take note of a command."""
        for part in self._model.parts:
            part.note(command, result)

    def _show_poses(self, command: PosesSoFar, result: TickResult) -> None:
        """Map the scans whose poses a job has made so far."""
        model, poses = self._model, command.poses
        if not self._healing.is_following or not 0 < len(poses) <= model.recording.log.n_scans:
            return
        if model.is_catching_up:
            return  # with the poses from before; there are newer ones soon
        model.playback.playing = False
        is_new = self._healing.show(poses)
        self._tell(command, result)
        model.go_to(len(poses))
        model.updated(result, is_new=is_new)

    def _end_poses(self, trajectory: str | None, result: TickResult) -> None:
        """Show the whole map along the trajectory that the job has made, None: along the one from before."""
        model = self._model
        before = self._healing.end()
        chosen = before if trajectory is None else trajectory
        if before is None or chosen is None or chosen not in model.recording.log.trajectories:
            return
        for part in model.parts:
            part.forget()
        is_other = chosen != model.recording.trajectory
        if is_other:
            model.recording.choose(chosen)
        model.go_to(model.recording.log.n_scans)
        model.updated(result, is_new=is_other)
