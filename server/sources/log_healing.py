"""The map of a log session along the poses that a job has made so far: SLAM, or localization in a map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.sensors.scan import Trajectory
from server.sources.log_recording import LogRecording


class LogHealing:
    """Follows such a job until the user looks at something else."""

    def __init__(self, recording: LogRecording) -> None:
        self._recording = recording
        self._before: str | None = None  #: the trajectory from which the session began to follow; None: it does not
        self._name = ""  #: of the trajectory while the job runs
        self.is_following = False

    def begin(self, name: str) -> None:
        """Follow a job from now on, whose trajectory is called ``name``."""
        self.is_following = True
        self._name = name
        self._before = self._recording.trajectory

    def leave(self) -> None:
        """Follow it no longer: the user chose another trajectory or another scan."""
        self.is_following = False

    def show(self, poses: NDArray[np.float64]) -> bool:
        """Map along ``poses`` (k, 3), ``T_map_base``, of the first k scans; return whether the map is a new one.

        Scans after them continue the trajectory as the log's own poses move there, so that the grid has room for them.
        """
        log, count = self._recording.log, len(poses)
        before = self._before if self._before in log.trajectories else log.default_trajectory
        own = log.trajectory(before).poses
        correction = compose(poses[-1], inverse(own[count - 1]))
        whole = np.concatenate([poses, compose(correction, own[count:])])
        healing = Trajectory(whole, "poses that are being computed", "map", from_scans=True)
        log = replace(log, trajectories={**log.trajectories, self._name: healing})
        return self._recording.show(log, self._name)

    def end(self) -> str | None:
        """Return the trajectory to go back to where the job has made none; None where the session did not follow."""
        was, self.is_following = self.is_following, False
        return self._before if was else None
