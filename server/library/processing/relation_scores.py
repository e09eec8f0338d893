"""The score of a log's poses against known relations between places, compared with published results.

The odometry messages identified by the relations' stamps are read from the original file, in a process with limits.
"""

from __future__ import annotations

import asyncio
import math
import secrets
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, MapperError
from mapper.evaluation import PUBLISHED, benchmark_named, evaluate_relations
from mapper.evaluation.published import PublishedResult
from mapper.io import logs
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses
from server.jobs.process import BoundedJob, JobLimits
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.reading_jobs import without_paths
from server.library.processing.recording_worker import RecordingWorker

if TYPE_CHECKING:
    from mapper.evaluation import ErrorSeries

MOST_BYTES = 4 << 20  #: of a file of relations: forty thousand lines


@dataclass(frozen=True, slots=True)
class MeanErrors:
    """Mean errors over ``count`` relations."""

    count: int
    translation_m: float
    rotation_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RelationMeans:
    """Mean errors over the relations of a file, without those ``left_out``; ``policy`` says how stamps were mapped.

    ``unambiguous`` are those over the relations whose stamps identify one message each, None if all do.
    """

    relations: int
    policy: str
    left_out: int
    all: MeanErrors
    unambiguous: MeanErrors | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseScore(RelationMeans):
    """The mean errors of a ``trajectory``, and ``published`` ones on the ``benchmark`` that the file's name states."""

    trajectory: str
    benchmark: str | None
    published: tuple[PublishedResult, ...]


@dataclass(frozen=True, slots=True)
class ScoreJob(BoundedJob[RelationMeans]):
    """Score ``poses`` (n, 3), one for each scan of the log ``source``, against the relations in the file ``relations``.

    ``stamps_ns`` (n,) are the scans', ``topic`` names the log's sensor. ``source`` is None for the sample, which has no
    file.
    """

    source: str | None
    relations: str
    topic: str | None
    stamps_ns: NDArray[np.int64]
    poses: NDArray[np.float64]
    limits: JobLimits

    def compute(self) -> RelationMeans:
        """Return the mean errors. Raises :class:`MapperError`."""
        from mapper.io.trajectories import read_relations  # noqa: PLC0415

        known = read_relations(Path(self.relations))
        records = None if self.source is None else logs.odometry_records(self.source, topic=self.topic)
        errors = evaluate_relations(known, TimedPoses(self.stamps_ns, self.poses), records)
        clear = errors.only_unambiguous() if errors.policy == "records" and errors.unambiguous.any() else None
        return RelationMeans(
            relations=len(known),
            policy=errors.policy,
            left_out=errors.left_out,
            all=_means(errors.translation, errors.rotation),
            unambiguous=None if clear is None else _means(*clear),
        )


def _means(translation: ErrorSeries, rotation: ErrorSeries) -> MeanErrors:
    return MeanErrors(
        len(translation.errors),
        float(translation.statistics.mean),
        math.degrees(float(rotation.statistics.mean)),
    )


class RelationScores:
    """Scores poses of the catalogue's logs, for waiting addresses and visitors in rotation.

    Used from the event loop only.
    """

    def __init__(self, catalogue: Catalogue, folder: Path, limits: JobLimits) -> None:
        self._folder, self._limits = folder, limits
        self._worker = RecordingWorker(catalogue, limits.memory_bytes)

    async def score(
        self,
        record: Record,
        visitor: str,
        log: ScanLog,
        trajectory: str,
        text: bytes,
        name: str,
        topic: str | None,
        *,
        address: str = "",
    ) -> PoseScore:
        """Return the mean errors of a trajectory over the relations in ``text``, a file called ``name``.

        ``benchmark`` is the log of the benchmark identified by the name, and ``published`` are the results on it.
        Raises :class:`MapperError` for a file without relations, or one that belongs to another log.
        """
        poses = log.trajectory(trajectory).poses
        relations = self._folder / f"relations-{secrets.token_hex(8)}"

        def job(source: str | None) -> ScoreJob:
            return ScoreJob(source, str(relations), topic, log.stamps_ns, poses, self._limits)

        try:
            async with self._worker.turn(visitor, address):
                await asyncio.to_thread(relations.write_bytes, text)
                is_sample = record.source == "sample"
                means = await (self._worker.of(job(None)) if is_sample else self._worker.of_recording(record, job))
        except MapperError as error:
            raise without_paths(error, relations, name) from None
        finally:
            await asyncio.to_thread(relations.unlink, missing_ok=True)
        benchmark = benchmark_named(name)
        published = () if benchmark is None else PUBLISHED[benchmark]
        return PoseScore(
            relations=means.relations,
            policy=means.policy,
            left_out=means.left_out,
            all=means.all,
            unambiguous=means.unambiguous,
            trajectory=trajectory,
            benchmark=benchmark,
            published=published,
        )

    async def close(self) -> None:
        """End the process."""
        await self._worker.close()


async def relations_text(chunks: AsyncIterator[bytes]) -> bytes:
    """Return a file of relations. Raises :class:`LimitError` if it exceeds 4 MiB."""
    text = bytearray()
    async for chunk in chunks:
        text += chunk
        if len(text) > MOST_BYTES:
            raise LimitError("relations.size", f"A file of relations may have {MOST_BYTES >> 20} MiB at most.")
    return bytes(text)
