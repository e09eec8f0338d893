"""The job of a worker process that brings two logs of one place into one frame. It writes a TUM file for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import LimitError
from mapper.sensors.joint_log import JointLog
from server.jobs import process
from server.library.processing.slam_job import log_in, lower_priority

DOING = "Merging these logs"  #: in errors
NAME = "merged"  #: of the trajectories
ENDINGS = (".first.tum", ".second.tum")  #: of the files, after the job's ``out``
BOTH, GRAPH = ".both.tum", ".graph"  #: the poses of the log of both, and the pose graph that they come from
LOG, STAGE = ".mcap", ".stage"  #: the scans of both as one log; what is done now


@dataclass(frozen=True, slots=True)
class MergeJob:
    """Merge the logs in the packs ``first`` and ``second``. ``out`` is the path of its files without their endings."""

    first: str
    second: str
    out: str
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[MergeJob], MergeOutcome]:
        """The function that does it."""
        return do_merge_job

    def time_error(self) -> LimitError:
        """Return the error for a job that takes too long."""
        return process.time_error(self.timeout_s, DOING, "merge")


@dataclass(frozen=True, slots=True)
class MergeOutcome:
    """Result of the merge of two logs: ``loops`` between them of ``tried``, and ``score``, 0 … 1, of their maps' match.

    ``topic`` names the sensors of the log of both, None where they are one. ``note`` says whether the clock of one log
    was set there; it is empty where it was not.
    """

    loops: int
    tried: int
    score: float
    cpu_s: float
    topic: str | None = None
    note: str = ""


def do_merge_job(job: MergeJob) -> MergeOutcome:
    """Do the job. Raises :class:`mapper.core.errors.MapperError` for logs that do not show one place, and limits."""
    lower_priority()
    return process.bounded(job.timeout_s, job.cpu_s, lambda: _merge(job), DOING, "merge")


def _merge(job: MergeJob) -> MergeOutcome:
    from mapper.io.export import tum_text, write_mcap  # noqa: PLC0415 - only this process needs SciPy and SLAM
    from mapper.sensors.scan import Trajectory  # noqa: PLC0415
    from mapper.slam import MergeProgress, merge_logs, merged_graph, merged_log  # noqa: PLC0415
    from server.library.packs.graph import graph_bytes  # noqa: PLC0415

    def begin(stage: str) -> None:
        with atomic_write(Path(job.out + STAGE)) as file:
            file.write(stage.encode())

    newest = ""

    def report(progress: MergeProgress) -> bool:
        nonlocal newest
        process.note_progress(0.97 * progress.fraction)
        if progress.stage != newest:
            newest = progress.stage
            begin(newest)
        return True

    logs = log_in(job.first), log_in(job.second)
    found = merge_logs(*logs, progress=report)
    for log, poses, ending in zip(logs, found.poses, ENDINGS, strict=True):
        one = replace(log, trajectories={**log.trajectories, NAME: Trajectory(poses)})
        Path(job.out + ending).write_text(tum_text(one, NAME), encoding="ascii")
    begin("writing")
    both, note = merged_log(logs, found.poses)
    with Path(job.out + LOG).open("wb") as mcap:
        write_mcap(mcap, both, trajectory=NAME)
    Path(job.out + BOTH).write_text(tum_text(both, NAME), encoding="ascii")
    Path(job.out + GRAPH).write_bytes(graph_bytes(*merged_graph(logs, found)))
    process.note_progress(1.0)
    topic = both.topic if isinstance(both, JointLog) else None
    return MergeOutcome(len(found.loops), len(found.tried), found.score, found.cpu_seconds, topic, note)
