"""A worker that has logs mapped on a Dask cluster."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any, TypeVar

from server.jobs.process import BoundedJob
from server.library.processing.fleet.cluster import Cluster
from server.library.processing.fleet.fleet_job import FleetJob

T = TypeVar("T")


class ClusterWorker:
    """Maps logs on ``cluster``, one at a time, each on the worker with the most free threads."""

    pid = 0

    def __init__(self, cluster: Cluster) -> None:
        self._cluster = cluster
        self._job: Future[Any] | None = None
        self.progress = 0.0

    async def prepare(self) -> None:
        """Do nothing, because the cluster manages its workers."""

    def submit(self, job: BoundedJob[T]) -> Future[T]:
        """Have a log mapped; see :meth:`Cluster.submit`."""
        sent: Any = job
        if not isinstance(sent, FleetJob):
            raise TypeError("only logs of a fleet are sent to a cluster")
        self.end()
        self.progress = 0.0
        done: Future[Any] = self._cluster.submit(sent, self._tell)
        self._job = done
        return done

    def _tell(self, fraction: float) -> None:
        self.progress = fraction

    def end(self) -> None:
        """Cancel the running job, if any."""
        job, self._job = self._job, None
        if job is not None:
            job.cancel()

    def close(self) -> None:
        """Cancel the running job. The cluster stays open, because it belongs to the caller."""
        self.end()
