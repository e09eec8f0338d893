"""Merging as a kind of job on logs: two logs of one place are transformed into one frame.

The result of a job is a trajectory for each of the two logs, and one more log with the scans of both. The worker
process writes a TUM file for each.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from mapper import slam
from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError
from mapper.io import export
from mapper.mapping.parameters import MappingConfig, as_mapped
from mapper.sensors.joint_log import JointLog
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog, Trajectory
from server.jobs import process
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.record import JobKind, JobRecord, JobStatus, shared
from server.library.annotations.trajectories import NewTrajectory
from server.library.packs.log import log_in
from server.library.processing.log_jobs import Parameters, Run
from server.library.processing.slam import NAME as SLAM

NAME = "merged"  #: of the trajectories
ENDINGS = (".first.tum", ".second.tum")  #: of the files, after the job's ``out``
BOTH, GRAPH = ".both.tum", ".graph"  #: the poses of the combined log, and their pose graph
LOG, STAGE = ".mcap", ".stage"  #: the combined log; the current stage


@dataclass(frozen=True, slots=True)
class MergeOutcome:
    """Result of merging two logs: ``loops`` between them of ``tried``, and the ``score``, 0 to 1, of their maps' match.

    ``topic`` names the sensors of the combined log, None if there is only one. ``note`` says whether the clock of one
    log was corrected in it; empty if not.
    """

    loops: int
    tried: int
    score: float
    cpu_s: float
    topic: str | None = None
    note: str = ""


@dataclass(frozen=True, slots=True)
class MergeJob(BoundedJob[MergeOutcome]):
    """Merge the logs in the packs ``first`` and ``second``. ``out`` is the path of its files without their endings."""

    BACKGROUND = True
    DOING = "Merging these logs"
    CODE = "merge"

    first: str
    second: str
    out: str
    limits: JobLimits

    def compute(self) -> MergeOutcome:
        """Return the result. Raises :class:`mapper.core.errors.MapperError` for logs of different places."""
        from mapper.slam.merged_log import merged_log  # noqa: PLC0415
        from server.library.packs.graph import graph_bytes  # noqa: PLC0415

        def begin(stage: str) -> None:
            with atomic_write(Path(self.out + STAGE)) as file:
                file.write(stage.encode())

        newest = ""

        def report(progress: slam.MergeProgress) -> bool:
            nonlocal newest
            process.note_progress(0.97 * progress.fraction)
            if progress.stage != newest:
                newest = progress.stage
                begin(newest)
            return True

        logs = log_in(self.first), log_in(self.second)
        merged = slam.merge_logs(*logs, progress=report)
        for log, poses, ending in zip(logs, merged.poses, ENDINGS, strict=True):
            corrected = replace(log, trajectories={**log.trajectories, NAME: Trajectory(poses)})
            Path(self.out + ending).write_text(export.tum_text(corrected, NAME), encoding="ascii")
        begin("writing")
        both, note = merged_log(logs, merged.poses)
        with Path(self.out + LOG).open("wb") as mcap:
            export.write_mcap(mcap, both, trajectory=NAME)
        Path(self.out + BOTH).write_text(export.tum_text(both, NAME), encoding="ascii")
        Path(self.out + GRAPH).write_bytes(graph_bytes(*slam.merged_graph(logs, merged)))
        process.note_progress(1.0)
        topic = both.topic if isinstance(both, JointLog) else None
        return MergeOutcome(len(merged.loops), len(merged.tried), merged.score, merged.cpu_seconds, topic, note)


# -- the kind of jobs -------------------------------------------------------------------------------------------------

PIECE = 1 << 20  #: bytes of the merged log stored at once


@dataclass(frozen=True, slots=True)
class MergeRequest:
    """A merge of a log with the log ``other``. ``topic`` and ``other_topic`` name their sensors.

    ``cut`` and ``other_cut`` have the options for cutting scans out of clouds and depth images of each (None: the
    defaults), ``mapping`` and ``other_mapping`` are parameters of the map of each, whose mount and time offset the
    merge uses (None: the defaults).
    """

    other: str = ""
    topic: str | None = None
    other_topic: str | None = None
    cut: dict[str, float] | None = None
    other_cut: dict[str, float] | None = None
    mapping: Parameters | None = None
    other_mapping: Parameters | None = None


@dataclass(frozen=True, slots=True)
class MergeReport:
    """Progress of a merge, and its current stage."""

    fraction: float
    stage: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeResult(MergeOutcome):
    """Result of a merge: ``trajectory`` of both logs, and the id and the name of the combined log."""

    trajectory: str
    log: str
    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeStatus(JobStatus):
    """State of a merge of a log with the log ``other``."""

    other: str | None
    result: MergeResult | None
    stage: str | None


class MergeKind:
    """Merging of logs: a :class:`LogJobKind`."""

    jobs = JobKind("merge", "Merging", "merge", MergeRequest, MergeResult, most_of_owner=1, most=20, joins=False)

    def checked(self, log_id: str, request: MergeRequest) -> MergeRequest:
        """Return a request with valid cuts and parameters. Raises :class:`ConfigError` if both logs are the same."""
        if request.other == log_id:
            raise ConfigError("merge.same", "This is the same log: choose another one to merge it with.")
        for cut in (request.cut, request.other_cut):
            PlanarCut.of(cut or {})
        for mapping in (request.mapping, request.other_mapping):
            MappingConfig().with_values(mapping or {})
        return request

    def others(self, request: MergeRequest) -> tuple[str, ...]:
        """Return the other log."""
        return (request.other,)

    def status(
        self, record: JobRecord[MergeRequest, MergeResult], status: JobStatus, newest: MergeReport | None
    ) -> MergeStatus:
        """Return the state of a job."""
        return MergeStatus(
            **shared(status),
            other=record.request.other or None,
            result=record.result,
            stage=None if newest is None else newest.stage,
        )

    async def run(self, run: Run[MergeRequest, MergeReport]) -> MergeResult:
        """Merge two logs, add a trajectory to each, and store the combined log."""
        request, ids = run.request, (run.log_id, run.request.other)
        first = await run.load(run.log_id, request.topic, request.cut)
        second = await run.load(ids[1], request.other_topic, request.other_cut)
        packs = (
            await run.packed(_as_mapped(first, request.mapping), "first.npz"),
            await run.packed(_as_mapped(second, request.other_mapping), "second.npz"),
        )
        job = MergeJob(*packs, str(run.out), run.limits)
        outcome = await run.follow(job, lambda out: _report(out, run.worker.progress))
        texts = [await run.made(ending) for ending in ENDINGS]
        names = [run.logs.get(run.owner, log_id).name for log_id in ids]
        for log_id, log, text, other in zip(ids, (first, second), texts, reversed(names), strict=True):
            description = f"poses in one frame with those of {other}, with {outcome.loops} loops between the two logs"
            await run.add(log_id, log, NewTrajectory(NAME, text, "slam", description))
        both = await run.logs.put(run.owner, _name_of_both(names), _pieces(run.out.with_name(run.out.name + LOG)))
        description = f"SLAM of {names[0]} and {names[1]}, with {outcome.loops} loops between the two logs"
        log = await run.logs.load(run.owner, both.id, outcome.topic)
        new = NewTrajectory(SLAM, await run.made(BOTH), "slam", description, await run.made(GRAPH))
        await run.add(both.id, log, new)
        return MergeResult(**asdict(outcome), trajectory=NAME, log=both.id, name=both.name)


def _as_mapped(log: ScanLog, mapping: Parameters | None) -> ScanLog:
    """Return a log with the mount and the time offset of its map."""
    return as_mapped(log, MappingConfig().with_values(mapping or {}))


def _name_of_both(names: list[str]) -> str:
    """Return the name of the combined log, with at most 60 characters of each."""
    first, second = (name.split(".", 1)[0][:60] or "log" for name in names)
    return f"{first} and {second}, merged.mcap"


async def _pieces(path: Path) -> AsyncIterator[bytes]:
    with await asyncio.to_thread(path.open, "rb") as file:
        while piece := await asyncio.to_thread(file.read, PIECE):
            yield piece


def _report(out: Path, fraction: float) -> MergeReport | None:
    """Return the last report of a running job; None before the first report."""
    try:
        return MergeReport(fraction, out.with_name(out.name + STAGE).read_text(encoding="ascii"))
    except OSError:
        return None
