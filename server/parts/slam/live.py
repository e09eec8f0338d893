"""View of SLAM in a simulation while the robot drives: its graph and the true path."""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from mapper.simulation.live_map import LiveMap
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.stream.layers import GraphLayer, TableLayer

EVERY = 5  #: scans after which the true path is rewritten
MOST_PLACES = 3000  #: of the true path


class SlamView(Part):
    """The layers of SLAM, while the map uses the poses that it corrects."""

    def __init__(self, mapper: LiveMap) -> None:
        self._mapper = mapper
        self.is_on = mapper.faults.corrects_poses
        self._graph: GraphLayer | None = None
        self._path: TableLayer | None = None
        self._scans = 0  # number of scans in the path

    @property
    def layers(self) -> tuple[GraphLayer | TableLayer, ...]:
        """The path, and the graph over it; empty while it is off."""
        return () if self._graph is None or self._path is None else (self._path, self._graph)

    def note(self, command: Struct, result: TickResult) -> None:  # noqa: ARG002 - the map says what the command did
        """Begin or end with the pose correction."""
        self.is_on = self._mapper.faults.corrects_poses
        if not self.is_on:
            self._graph = self._path = None

    def changed(self, result: TickResult) -> None:  # noqa: ARG002 - the recording says what is new
        """Write the layers."""
        from server.parts.slam.live_slam import LiveSlam  # noqa: PLC0415 - imports SLAM, which few sessions need

        mapper = self._mapper
        recording = mapper.recordings[-1]
        corrector = mapper.pose_correction.corrector_of(recording)
        if not isinstance(corrector, LiveSlam):
            self._graph = self._path = None
            return
        self._graph = self._graph or GraphLayer("slam", "SLAM", "pose_graph", ("x", "y", "yaw", "scan"))
        corrector.draw(self._graph)
        if self._path is None or not self._scans <= mapper.scans < self._scans + EVERY:
            self._path = self._path or TableLayer("true_path", "True path", "true_path", ("x", "y"), "path")
            self._scans = mapper.scans
            poses = recording.as_log().trajectory("true").poses
            self._path.set(poses[:: max(1, -(-len(poses) // MOST_PLACES)), :2].T.astype(np.float32))
