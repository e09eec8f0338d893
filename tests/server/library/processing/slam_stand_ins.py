"""Stand-ins for SLAM in a worker, each in place of ``SlamJob.compute``, and a worker of one thread."""

from __future__ import annotations

import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.errors import ConfigError
from mapper.diagnosis.figures import MapFigures
from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.slam import LoopCandidates
from server.library.packs.graph import graph_bytes
from server.library.processing.fleet.fleet_job import MapFacts
from server.library.processing.log_jobs import write_report
from server.library.processing.merging import BOTH, ENDINGS, LOG, STAGE, MergeJob, MergeOutcome
from server.library.processing.merging import GRAPH as MERGED_GRAPH
from server.library.processing.slam import GRAPH, TUM, PartialPoses, SlamJob, SlamOutcome
from tests.server.library.small_logs import carmen, tum

PATIENCE_S = 60.0
SECOND_START = 100  #: of the second log of a merge
Y = 5.0  #: of the poses that a stand-in has found, metres
#: What the mapping of one of many logs returns.
FACTS = MapFacts(
    scans=1, beams=3, trajectory="scan", rows=2, cols=3, resolution=0.1, contrast=None, findings=(), picture=False,
    cpu_s=0.5,
)  # fmt: skip


def chain(scans: int) -> tuple[PoseGraph, LoopCandidates]:
    """A graph of ``scans`` nodes one metre apart, with a loop that is half a metre too short."""
    poses = np.stack([np.arange(scans), np.full(scans, Y), np.zeros(scans)], axis=1)
    i, j = np.arange(scans - 1), np.arange(1, scans)
    relative = np.tile([1.0, 0.0, 0.0], (scans - 1, 1))
    graph = PoseGraph(
        nodes=np.arange(scans),
        poses=poses,
        i=np.append(i, 0),
        j=np.append(j, scans - 1),
        relative=np.concatenate([relative, [[scans - 1.5, 0.0, 0.0]]]),
        information=np.tile(100.0 * np.eye(3), (scans, 1, 1)),
        kind=np.append(np.full(scans - 1, ODOMETRY), LOOP),
        locked=np.zeros(scans, dtype=bool),
        residual=np.zeros(scans),
        weight=np.ones(scans),
    )
    tried = LoopCandidates(
        np.array([0, 1]),
        np.array([scans - 1, scans - 2]),
        np.array([0.9, 0.4]),
        np.array([0.8, 0.3]),
        np.array([True, False]),
        ("", "only 30 % of the points are on walls of the earlier scans"),
    )
    return graph, tried


def told(job: SlamJob, fraction: float, scans: int) -> None:
    """Report progress as the job does."""
    poses = np.stack([np.arange(scans), np.full(scans, Y), np.zeros(scans)], axis=1)
    write_report(job.out, PartialPoses(fraction, "front end", 1, poses))


def quick(job: SlamJob) -> SlamOutcome:
    """Find all scans of a log of six on a line."""
    told(job, 0.5, 3)
    Path(job.out + TUM).write_text("".join(f"{k}.0 {k}.0 {Y} 0 0 0 0 1\n" for k in range(6)))
    Path(job.out + GRAPH).write_bytes(graph_bytes(*chain(6)))
    return SlamOutcome("scan", 1, 6, 0.25, MapFigures(0.3, 0.12, 0.25), MapFigures(None, None, 0.75), ("A note.",))


def endless(job: SlamJob) -> SlamOutcome:
    """Report that half is done, and go on until the files of the job are removed."""
    told(job, 0.5, 3)
    deadline = time.monotonic() + PATIENCE_S
    while Path(job.pack).exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return SlamOutcome(None, 0, 0, 0.0, MapFigures(None, None, 0.0), MapFigures(None, None, 0.0), ())


def quick_merge(job: MergeJob) -> MergeOutcome:
    """Lay both logs, of six scans each, 2 m to the left; the second begins at :data:`SECOND_START`."""
    for ending, start in zip(ENDINGS, (0, SECOND_START), strict=True):
        Path(job.out + ending).write_bytes(tum(6, 2.0, start))
    Path(job.out + LOG).write_bytes(carmen(12, 0))
    Path(job.out + BOTH).write_bytes(tum(12, 2.0))
    Path(job.out + MERGED_GRAPH).write_bytes(graph_bytes(*chain(12)))
    return MergeOutcome(7, 9, 0.8, 0.5)


def endless_merge(job: MergeJob) -> MergeOutcome:
    """Say that loops are tried, and go on until the files of the job are removed."""
    Path(job.out + STAGE).write_text("loops")
    deadline = time.monotonic() + PATIENCE_S
    while Path(job.first).exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return MergeOutcome(0, 0, 0.0, 0.0)


def refusing(job: SlamJob) -> SlamOutcome:
    """Refuse the log, as SLAM does one without returns."""
    raise ConfigError("slam.no_returns", "No scan of the log has a return.")


def broken(job: SlamJob) -> SlamOutcome:
    """A defect."""
    raise ZeroDivisionError("a secret of the server")


class ThreadWorker:
    """A worker of one thread of this process."""

    pid = 0
    progress = 0.0

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1)
        self.ended = 0

    async def prepare(self) -> None:
        """It is there."""

    def submit(self, job: Any) -> Future[Any]:
        return self._pool.submit(job.compute)

    def end(self) -> None:
        self.ended += 1

    def close(self) -> None:
        self._pool.shutdown(wait=True)
