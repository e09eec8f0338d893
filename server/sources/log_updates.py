"""Commands of the service to a log session, which no client can send: other trajectories, another sensor, a job."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from mapper.core.errors import MapperError
from mapper.core.se2 import compose, inverse
from mapper.sensors.scan import ScanLog, Trajectory
from server.sessions.commands import (
    FollowPoses,
    PosesEnded,
    PosesSoFar,
    UpdateLog,
    UseSensor,
)
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.sessions.view import LogView, Playback
from server.sources.log_recording import LogRecording
from server.stream.messages import ErrorMessage


class FollowedPoses:
    """Maps along the poses that SLAM or localization has computed so far, until the user selects something else."""

    def __init__(self, recording: LogRecording) -> None:
        self._recording = recording
        self._before: str | None = None  #: the trajectory before following began; None if it does not follow
        self._name = ""  #: of the trajectory while the job runs
        self.is_following = False

    def begin(self, name: str) -> None:
        """Start following a job, whose trajectory is called ``name``."""
        self.is_following = True
        self._name = name
        self._before = self._recording.trajectory

    def leave(self) -> None:
        """Stop following, because the user chose another trajectory or another scan."""
        self.is_following = False

    def show(self, poses: NDArray[np.float64], is_known: NDArray[np.bool_] | None) -> bool:
        """Map along ``poses`` (k, 3), ``T_map_base``, of the first k scans; return whether the map is a new one.

        Poses for which ``is_known`` (k,) is False are left out. Later scans continue the trajectory with the motion of
        the log's own poses, so that the grid is large enough for them.
        """
        log, count = self._recording.log, len(poses)
        before = self._before if self._before in log.trajectories else log.default_trajectory
        own = log.trajectory(before).poses
        correction = compose(poses[-1], inverse(own[count - 1]))
        whole = np.concatenate([poses, compose(correction, own[count:])])
        known = None if is_known is None else np.concatenate([is_known, np.ones(len(whole) - count, dtype=np.bool_)])
        followed = Trajectory(whole, "poses that are being computed", "map", from_scans=True, is_known=known)
        log = replace(log, trajectories={**log.trajectories, self._name: followed})
        return self._recording.show(log, self._name)

    def end(self) -> str | None:
        """Return the trajectory to go back to if the job produced none; None if the session did not follow."""
        was, self.is_following = self.is_following, False
        return self._before if was else None


class Updated(Protocol):
    """The interface of a log session's model for updates."""

    recording: LogRecording
    parts: Sequence[Part]
    playback: Playback

    @property
    def is_catching_up(self) -> bool:
        """Whether the map is not yet at the requested scan."""

    def go_to(self, index: int) -> None:
        """Request a map of this number of scans."""

    def use_sensor(self, log: ScanLog, view: LogView, result: TickResult) -> None:
        """Restart the map with another sensor of the log, or with other options for cutting scans."""

    def updated(self, result: TickResult, *, is_new: bool) -> None:
        """Continue after the log got other trajectories. ``is_new`` says whether the map was restarted."""


class LogUpdates(Part):
    """The part that carries out these commands on a worker thread."""

    commands = (
        UpdateLog,
        UseSensor,
        FollowPoses,
        PosesSoFar,
        PosesEnded,
    )
    is_on = False  # it only receives commands

    def __init__(self, model: Updated, followed: FollowedPoses) -> None:
        self._model, self._followed = model, followed

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
                    result.notices.append(ErrorMessage(error.code, error.message))
            case FollowPoses(name=name):
                self._followed.begin(name)
            case PosesSoFar():
                self._show_poses(command, result)
            case PosesEnded(trajectory=trajectory):
                self._tell(command, result)
                self._end_poses(trajectory, result)
        result.changed = True

    def _tell(self, command: Struct, result: TickResult) -> None:
        """Pass a command to the other parts."""
        for part in self._model.parts:
            part.note(command, result)

    def _show_poses(self, command: PosesSoFar, result: TickResult) -> None:
        """Map the scans whose poses a job has computed so far."""
        model, poses = self._model, command.poses
        if not self._followed.is_following or not 0 < len(poses) <= model.recording.log.n_scans:
            return
        if model.is_catching_up:
            return  # with the previous poses; newer ones follow soon
        model.playback.playing = False
        is_new = self._followed.show(poses, command.is_known)
        self._tell(command, result)
        model.go_to(len(poses))
        model.updated(result, is_new=is_new)

    def _end_poses(self, trajectory: str | None, result: TickResult) -> None:
        """Show the whole map along the trajectory that the job produced; None: along the previous one."""
        model = self._model
        before = self._followed.end()
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
