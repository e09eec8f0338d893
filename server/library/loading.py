"""The scans of logs that a visitor may open: of one sensor or of several as one log, after the job that reads it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.sensors.joint_log import SEPARATOR, JointLog
from mapper.sensors.planar.options import PlanarCut, is_cut
from mapper.sensors.scan import ScanLog
from server.library.logs.cache import LogCache
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import LogNotFoundError, Record
from server.library.logs.sample import SAMPLE_ID, Sample
from server.library.packs.costmaps import read_costmap_pack
from server.library.packs.log import StalePackError
from server.library.packs.reference_map import ReferenceMap, read_reference_map
from server.library.processing.reader import Readers
from server.library.processing.reading_jobs import Jobs, unreadable
from server.library.scans import Scans
from server.library.shared_folder import SharedFolder

if TYPE_CHECKING:
    from mapper.io.costmaps import CostmapStream
    from server.library.annotations.tags import Tags
    from server.library.annotations.trajectories import Trajectories
    from server.library.packs.volume import VolumeSource


MAX_TOGETHER = 32  #: sensors of one log that can be mapped together
SONAR = "sensor_msgs/Range"


@dataclass(frozen=True, slots=True)
class Loading:
    """Loads logs; ``get`` returns the record of a log that a visitor may open, or raises."""

    get: Callable[[str, str], Record]
    catalogue: Catalogue
    jobs: Jobs
    readers: Readers
    sample: Sample
    scans: Scans
    cache: LogCache

    async def load(self, owner: str, log_id: str, topic: str | None, cut: PlanarCut | None) -> ScanLog:
        """Return one sensor of a log, or several as one log; see :meth:`Library.load`."""
        if cut == PlanarCut():
            cut = None
        log = None if topic is not None and SEPARATOR in topic else await self._load(owner, log_id, topic, cut)
        names = [] if topic is None else topic.split(SEPARATOR)
        if log is not None and topic is None and log.beam_width > 0.0:
            names = [topic.name for topic in log.topics if topic.type == SONAR and topic.beams][:MAX_TOGETHER]
        if len(names) < 2 and log is not None:
            return log
        if len(names) > MAX_TOGETHER:
            raise LimitError("log.sensors", f"At most {MAX_TOGETHER} sensors are mapped together here.")
        key = f"{log_id}#{SEPARATOR.join(names)}#{'' if cut is None else cut.values}"
        cached = self.cache.get(key)
        if cached is not None:
            return cached
        parts = [await self._load(owner, log_id, name, cut) for name in dict.fromkeys(names)]
        try:
            joint = await asyncio.to_thread(JointLog.of, parts)
        except ConfigError:
            if log is None:
                raise
            return log  # the sonars' poses are in different frames, so one of them by itself
        self.cache.put(key, joint)
        return joint

    async def _load(self, owner: str, log_id: str, topic: str | None, cut: PlanarCut | None) -> ScanLog:
        record = self.get(owner, log_id)
        if record.source == "upload" and time.time() - record.used_s > DAY_S:
            record = self.catalogue.mark_used(record)
        if record.source == "sample":
            return await self.sample.load()
        if cut is not None:
            record = await self._settled(owner, log_id)
            cut_topic = _cut_topic(record, topic)
            if cut_topic is not None:
                return await self.scans.of_sensor(record, cut_topic, cut)
        if topic is not None:
            record = await self._settled(owner, log_id)
            if topic not in [topic.name for topic in (record.summary.topics if record.summary else ()) if topic.chosen]:
                return await self.scans.of_sensor(record, topic)
        cached = self.cache.get(log_id)
        if cached is not None:
            return cached
        if record.summary is not None and record.summary.costmaps:
            raise ReadError("log.no_scans", "The recording has costmaps and no scans.")
        if record.summary is not None and record.summary.clouds:
            raise ReadError("log.no_scans", "The file has point clouds and no planar scans: it makes a map in 3D.")
        if record.summary is not None and record.summary.map is not None:
            raise ReadError("log.no_scans", "This is a map: it has no scans.")
        for _ in range(3):  # one more than reading takes, because the survey may be reading this log, and packs nothing
            record = await self._settled(owner, log_id)
            try:
                return await self.scans.packed(record)
            except StalePackError:
                self.jobs.queue(self.get(owner, log_id))
        raise unreadable()

    async def costmaps(self, owner: str, log_id: str) -> dict[str, CostmapStream] | None:
        """Return the costmaps of a recording without scans, None for any other log; see :meth:`load`."""
        record = self.get(owner, log_id)
        if record.source == "sample":
            return None
        for _ in range(3):
            record = await self._settled(owner, log_id)
            if record.summary is not None and not record.summary.costmaps:
                return None
            try:
                await self.catalogue.fetch(record.id)
                return await asyncio.to_thread(read_costmap_pack, self.catalogue.pack(record.id))
            except StalePackError:
                if record.summary is None:
                    return None
                self.jobs.queue(record)
        raise unreadable()

    async def volume(self, owner: str, log_id: str, topic: str | None) -> VolumeSource:
        """Return the source of a log's 3D map; see :meth:`load`.

        ``topic`` names the clouds if a recording has several. Those of a recording with planar scans are read on
        request. Raises :class:`ReadError` for a log without clouds.
        """
        record = self.get(owner, log_id)
        if record.source == "sample":
            raise ReadError("clouds.none", "The sample has no point clouds.")
        if record.source == "upload" and time.time() - record.used_s > DAY_S:
            self.catalogue.mark_used(record)
        for _ in range(3):
            record = await self._settled(owner, log_id)
            if topic is not None or (record.summary is not None and not record.summary.clouds):
                return await self.scans.of_clouds(record, topic)
            from server.library.packs.volume import read_volume_pack  # noqa: PLC0415 - few logs are clouds

            await self.catalogue.fetch(record.id)
            try:
                return await asyncio.to_thread(read_volume_pack, self.catalogue.pack(record.id))
            except StalePackError:
                self.jobs.queue(record)
        raise unreadable()

    async def reference_map(self, owner: str, log_id: str) -> ReferenceMap | None:
        """Return the map in map files, None for any other log; see :meth:`load`."""
        record = self.get(owner, log_id)
        if record.source == "sample":
            return None
        for _ in range(3):
            record = await self._settled(owner, log_id)
            if record.summary is not None and record.summary.map is None:
                return None
            try:
                await self.catalogue.fetch(record.id)
                reference = await asyncio.to_thread(read_reference_map, self.catalogue.pack(record.id))
            except ConfigError:
                if record.summary is None:
                    return None
                self.jobs.queue(record)
            else:
                return replace(reference, title=record.name)
        raise unreadable()

    def opening(self, log_id: str) -> tuple[str, float | None]:
        """Return what :meth:`load` of a log currently waits for, in words, and its completed share, None if unknown."""
        record = self.catalogue.get(log_id)
        if record is not None and record.state == "reading":
            return "Reading the log", self.readers.of(record).progress
        if record is not None and log_id in self.scans.read_now:
            return "Reading the sensor’s scans", self.readers.of(record).progress
        if record is not None and record.state == "queued":
            return "Waiting until other logs are read", None
        return "Loading the log", None

    async def _settled(self, owner: str, log_id: str) -> Record:
        """Return the record of a log after the running job; raise the reader's error."""
        await self.jobs.settled(log_id)
        record = self.get(owner, log_id)
        if record.error is not None:
            raise ReadError(record.error.code, record.error.message)
        return record


def _cut_topic(record: Record, topic: str | None) -> str | None:
    """Return the topic (for None, the log's own) if scans are cut out of its messages; otherwise None."""
    for known_topic in record.summary.topics if record.summary else ():
        if is_cut(known_topic.type) and (known_topic.chosen if topic is None else known_topic.name == topic):
            return known_topic.name
    return None


DAY_S = 86_400.0


@dataclass(frozen=True, slots=True)
class LibraryLimits:
    """Limits on uploads, stored bytes and reading."""

    max_logs_per_owner: int = 50
    max_total_bytes: int = 20 << 30  #: bytes of all uploads together, including the data read from them
    max_owner_bytes: int = 10 << 30  #: bytes of one visitor's uploads
    max_uploads_at_once: int = 8
    max_uploads_of_owner: int = 4  #: at once, so that a slow sender cannot block others
    keep_s: float = 30 * DAY_S  #: seconds after its last use at which an upload is deleted
    idle_s: float = 30.0  #: seconds with almost no data after which an upload is cancelled
    read_timeout_s: float = 120.0  #: more for a large file, see :class:`server.library.processing.reader.Reader`
    read_cpu_s: float = 100.0  #: seconds of processor time, likewise
    read_memory_bytes: int = 6 << 30  #: address space of the reading process
    lease_s: float = 15.0  #: for which a killed or disconnected service keeps its jobs from others
    cache_bytes: int = 512 << 20  #: bytes of logs kept in memory

    def with_room_for(self, upload_bytes: int) -> LibraryLimits:
        """Return limits with room for two uploads of this size of one visitor, and for four of all visitors."""
        return replace(
            self,
            max_owner_bytes=max(self.max_owner_bytes, 2 * upload_bytes),
            max_total_bytes=max(self.max_total_bytes, 4 * upload_bytes),
        )


class VisibleLogs:
    """Own uploads, the logs of the folder, and the sample, each with the visitor's additions."""

    def __init__(
        self,
        catalogue: Catalogue,
        folder: SharedFolder,
        sample: Sample,
        reading: tuple[Jobs, Readers],
        added: tuple[Tags, Trajectories],
    ) -> None:
        self._catalogue, self._folder, self._sample = catalogue, folder, sample
        self._jobs, self._readers = reading
        self._tags, self._trajectories = added

    async def list(self, owner: str) -> Sequence[Record]:
        """Return the logs that ``owner`` may open: own uploads (newest first), the folder's, the sample."""
        await self._folder.look()
        self._folder.begin_survey()
        self._sample.begin()
        pictured = await asyncio.to_thread(self._catalogue.pictured)
        records = [*self._uploads(owner), *self._folder.records(), self._sample.record]
        return [self._as_seen_by(owner, record, is_pictured=record.id in pictured) for record in records]

    def files(self, owner: str) -> Sequence[Record]:
        """Return the logs with files that ``owner`` may open, as of the last scan of the folder."""
        return [*self._uploads(owner), *self._folder.records()]

    def _uploads(self, owner: str) -> Sequence[Record]:
        own = (record for record in self._catalogue.uploaded() if record.owner == owner)
        return sorted(own, key=lambda record: record.created_s, reverse=True)

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log that ``owner`` may open; raise :class:`LogNotFoundError` for any other."""
        if log_id == SAMPLE_ID:
            self._sample.begin()  # each process of the service creates it
            return self._as_seen_by(owner, self._sample.record, is_pictured=self._catalogue.picture(log_id).exists())
        record = self._catalogue.get(log_id)
        if log_id in self._catalogue.folder_logs:
            record = self._folder.record(self._catalogue.folder_logs[log_id])
        elif record is not None and (record.source == "folder" or record.owner != owner):  # deleted, or another's
            record = None
        if record is None:
            raise LogNotFoundError("log.not_found", "There is no such log.")
        return self._as_seen_by(owner, record, is_pictured=self._catalogue.picture(log_id).exists())

    def _as_seen_by(self, owner: str, record: Record, *, is_pictured: bool) -> Record:
        """Return a record with the current progress, and with the additions of ``owner``."""
        is_read = record.state == "reading"
        progress = self._jobs.progress(record) if is_read else record.progress
        reading_s = self._readers.of(record).elapsed_s if is_read else None
        added = tuple(trajectory.public() for trajectory in self._trajectories.of(owner, record.id))
        has_picture = record.state == "ready" and is_pictured
        tags = self._tags.of(owner, record.id)
        return replace(record, progress=progress, reading_s=reading_s, has_picture=has_picture, tags=tags, added=added)

    async def picture(self, owner: str, log_id: str, *, dark: bool = False) -> bytes:
        """Return the picture of a log's map as PNG, in the colours of a light or a dark page.

        Raises :class:`LogNotFoundError`, also if there is no picture.
        """
        from server.library.packs.picture import read_picture  # noqa: PLC0415 - Pillow and the replay of logs

        record = self.get(owner, log_id)
        await self._catalogue.fetch(record.id)
        try:
            return await asyncio.to_thread(read_picture, self._catalogue.picture(record.id), dark=dark)
        except OSError:
            raise LogNotFoundError("log.no_picture", "There is no picture of this log’s map yet.") from None
