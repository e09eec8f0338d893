"""Kinds of jobs that add a trajectory to a log: SLAM, and localization in a map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from sqlalchemy import Table

from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.jobs.process import WorkerJob
from server.library.annotations.trajectories import NewTrajectory, Trajectories
from server.library.logs.records import Record
from server.library.processing.pose_job_record import PoseJobRecord


class Logs(Protocol):
    """Interface of the library that the jobs use."""

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log."""

    async def load(self, owner: str, log_id: str, topic: str | None = None, cut: PlanarCut | None = None) -> ScanLog:
        """Return a log."""

    @property
    def trajectories(self) -> Trajectories:
        """The trajectories that are added to logs."""


@dataclass(frozen=True, slots=True)
class JobLimits:
    """Limits of one job: seconds of elapsed and of processor time, bytes of address space."""

    timeout_s: float = 3600.0
    cpu_s: float = 7200.0
    memory_bytes: int = 6 << 30


class Progress(Protocol):
    """Progress of a running job."""

    @property
    def fraction(self) -> float:
        """Share that is done, from 0 to 1."""


P = TypeVar("P", bound=Progress)
T = TypeVar("T")


class JobKind(Protocol[P, T]):
    """One kind of jobs. ``name`` is in the codes of errors, ``title`` in their sentences; ``table`` has the records."""

    name: str
    title: str
    table: Table

    def checked(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Return the parameters that are kept of a job (worker thread). Raises :class:`ConfigError`."""

    async def job(self, record: PoseJobRecord, pack: Path, out: Path, limits: JobLimits) -> WorkerJob[T]:
        """Return the job on the log in ``pack``; ``out`` is the path of its files without their endings."""

    def read_progress(self, out: Path) -> P | None:
        """Return what a running job has reported last (worker thread); None before the first report."""

    def shown(self, newest: P | None) -> dict[str, Any]:
        """Return what the HTTP interface shows of a report."""

    async def finished(
        self, record: PoseJobRecord, outcome: T, out: Path, own_names: Sequence[str]
    ) -> tuple[NewTrajectory, dict[str, Any]]:
        """Return the trajectory that a job has made of a log with ``own_names``, and what is shown of the result."""
