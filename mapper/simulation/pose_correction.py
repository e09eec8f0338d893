"""Pose correction of a live world while the robot drives.

SLAM is a layer above the simulation, so a :class:`Corrector` is created by a function that the owner of the world
passes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import WorkCancelledError
from mapper.core.se2 import between_one, compose_one, pose_tuple
from mapper.sensors.scan import ScanLog
from mapper.simulation.recording import Recording
from mapper.simulation.robot import PoseTuple

PLACED_M = 0.75  #: metres between two scans: a driving robot is slower, so it was teleported


class Corrector(Protocol):
    """Corrects the poses of the scans of one sensor incrementally."""

    def add(self, ranges: NDArray[np.float32], motion: PoseTuple) -> bool:
        """Add a scan (n_beams,), ``motion`` (3,) after the previous one; return whether earlier poses have moved."""

    @property
    def poses(self) -> NDArray[np.float64]:
        """All poses so far (n, 3), ``T_map_base``."""

    @property
    def newest(self) -> PoseTuple:
        """The last pose."""


MakeCorrector = Callable[[ScanLog, PoseTuple], Corrector | None]
"""Creates the corrector of a log's sensor from the pose of its first scan; None for a sensor that has none."""


class _Reckoning:
    """Dead reckoning for a sensor without a corrector."""

    def __init__(self, start: PoseTuple) -> None:
        self._start = start
        self._poses: list[PoseTuple] = []

    def add(self, ranges: NDArray[np.float32], motion: PoseTuple) -> bool:  # noqa: ARG002 - a corrector
        self._poses.append(compose_one(self._poses[-1], motion) if self._poses else self._start)
        return False

    @property
    def poses(self) -> NDArray[np.float64]:
        return np.array(self._poses)

    @property
    def newest(self) -> PoseTuple:
        return self._poses[-1]


@dataclass(slots=True)
class _Part:
    """A recording, and the numbers of its scans added to its corrector, in order."""

    recording: Recording
    corrector: Corrector | None = None
    numbers: list[int] = field(default_factory=list)

    @property
    def newest(self) -> int:
        return self.numbers[-1] if self.numbers else -1


class PoseCorrection:
    """The corrected poses of a world's recordings, added in the order in which they were taken.

    The pose of a teleported robot is that of its restarted odometry. Poses of a sensor without a corrector follow the
    odometry.
    """

    def __init__(self, make: MakeCorrector) -> None:
        self._make = make
        self._parts: dict[int, _Part] = {}  #: by the identity of their recordings, to which they hold references
        self._last: tuple[PoseTuple, PoseTuple] | None = None  #: the newest scan's corrected pose, and its odometry

    def add(
        self, recording: Recording, may_continue: Callable[[float], bool] = lambda _: True, *, specular: bool = False
    ) -> bool:
        """Add the new scans of a recording; return whether poses of earlier ones have moved.

        With ``specular`` their readings are affected by polished walls. ``may_continue`` is called with the fraction
        done; if it returns False, :class:`WorkCancelledError` is raised, and the rest can be added later.
        """
        part = self._parts.setdefault(id(recording), _Part(recording))
        log = recording.as_log()
        odometry = log.trajectory("odometry").poses
        rows = np.flatnonzero(recording.numbers > part.newest).tolist()
        moved = False
        for done, row in enumerate(rows):
            if not may_continue(done / len(rows)):
                raise WorkCancelledError("world.unwanted", "The corrected poses are not wanted any more.")
            ranges = recording.reported(slice(row, row + 1), specular=specular)[0]
            moved |= self._add_one(part, log, ranges, pose_tuple(odometry[row]))
            part.numbers.append(int(recording.numbers[row]))
        return moved

    def _add_one(self, part: _Part, log: ScanLog, ranges: NDArray[np.float32], odometry: PoseTuple) -> bool:
        at, motion = odometry, (0.0, 0.0, 0.0)
        if self._last is not None:
            corrected, before = self._last
            motion = between_one(before, odometry)
            if math.hypot(motion[0], motion[1]) > PLACED_M:
                motion = between_one(corrected, odometry)
            at = compose_one(corrected, motion)
        if part.corrector is None:
            part.corrector = self._make(log, at) or _Reckoning(at)
        moved = part.corrector.add(ranges, motion)
        self._last = part.corrector.newest, odometry
        return moved

    def poses_of(self, recording: Recording) -> NDArray[np.float64] | None:
        """Return the corrected poses (n, 3) of a recording's scans; None if some are not yet added."""
        part = self._parts.get(id(recording))
        if part is None or part.corrector is None or int(recording.numbers[-1]) > part.newest:
            return None
        rows = np.searchsorted(np.array(part.numbers), recording.numbers)
        return np.asarray(part.corrector.poses[rows], dtype=np.float64)

    def corrector_of(self, recording: Recording) -> Corrector | None:
        """Return the corrector of a recording; None if there is none yet."""
        part = self._parts.get(id(recording))
        return None if part is None else part.corrector
