"""The library: the logs that a visitor may open, their states, and their contents.

It has three sources: uploads (private to the visitor who made them), a folder that the operator names (for all
visitors, read-only) and one built-in sample. All methods run on the event loop; files and readers work elsewhere.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncIterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import TYPE_CHECKING

from mapper.io.contents.model import Contents, Series
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.jobs.leases import Leases
from server.jobs.process import JobLimits
from server.jobs.record import Failure
from server.jobs.workers import Worker, worker_at
from server.library.annotations.added import Added
from server.library.annotations.links import Links
from server.library.annotations.notes import Notes
from server.library.annotations.puzzles import MadePuzzles
from server.library.annotations.tags import Tags
from server.library.annotations.trajectories import NewTrajectory, Trajectories, text_of
from server.library.loading import LibraryLimits, Loading, VisibleLogs
from server.library.logs.cache import LogCache
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import LogReadOnlyError, Record
from server.library.logs.rows import LogRows
from server.library.logs.sample import SAMPLE_ID, Sample
from server.library.packs.reference_map import ReferenceMap
from server.library.processing.field_lookups import FieldLookups
from server.library.processing.fleet.cluster import Cluster
from server.library.processing.fleet.fleet_jobs import FleetJobs
from server.library.processing.inspections import Inspections
from server.library.processing.job_rows import JobRowsOfLogs
from server.library.processing.localization import LocalizationKind
from server.library.processing.log_jobs import LogJobs
from server.library.processing.merging import MergeKind
from server.library.processing.moment_pictures import MomentPicture, MomentPictures
from server.library.processing.reader import QUICK_S, Reader, Readers
from server.library.processing.reading_jobs import Jobs
from server.library.processing.reference_maps import ReferenceMaps
from server.library.processing.relation_scores import RelationScores
from server.library.processing.slam import SlamKind
from server.library.scans import Scans
from server.library.shared_folder import SharedFolder
from server.library.store.blobs import Blobs
from server.library.store.changes import Changes
from server.library.store.common_files import CommonFiles
from server.library.store.database import Database
from server.library.store.identity import belong_together
from server.library.store.known_paths import KnownPaths
from server.library.store.lease_rows import LeaseRows
from server.library.store.sign_in_ends import SignInEnds
from server.library.uploads.receiver import Part, UploadReceiver
from server.library.uploads.slots import UploadSlots
from server.library.uploads.uploads import Declared, Places, Sender, Uploads
from server.settings import Settings
from server.storage import private_folder

if TYPE_CHECKING:
    from mapper.io.contents.fields import TopicFields
    from mapper.io.contents.message_tree import RawMessage
    from mapper.io.costmaps import CostmapStream
    from server.library.packs.volume import VolumeSource


class Library:
    """The logs of one server. The constructor opens its stores and may take a while; then call :meth:`start`.

    Call :meth:`close` at the end. ``readers`` may outlive the library; by default the library creates its own. Raises
    :class:`StorageError` if the stores cannot be opened.
    """

    def __init__(self, settings: Settings, limits: LibraryLimits | None = None, readers: Readers | None = None) -> None:
        self._limits = limits or LibraryLimits().with_room_for(settings.max_upload_bytes)
        self._slots = UploadSlots(
            self._limits.max_uploads_at_once, self._limits.max_uploads_of_owner, self._limits.idle_s
        )
        self._own_readers = readers is None
        self._cache = LogCache(self._limits.cache_bytes)
        root = settings.data_dir / "library"
        scratch = root / "incoming"
        for folder in (root, root / "packs", root / "pictures", scratch):
            private_folder(folder)
        memory = self._limits.read_memory_bytes

        def new_worker() -> Worker:
            return worker_at(settings.executor, memory, scratch)

        def new_reader(quick_s: float = math.inf) -> Reader:
            return Reader(
                timeout_s=self._limits.read_timeout_s,
                memory_bytes=memory,
                cpu_s=self._limits.read_cpu_s,
                worker=new_worker(),
                scratch=scratch,
                quick_s=quick_s,
            )

        self._readers = readers or Readers(small=new_reader(QUICK_S), large=new_reader())
        self._blobs = blobs = Blobs.at(settings.blobs, root)
        self._database = Database.open(settings.database_url, root, of_workers=settings.workers > 1)
        self._known_paths = KnownPaths([root, scratch, *([self._database.file] if self._database.file else [])])
        self.links = Links(self._database)
        self.notes = Notes(self._database)
        self.sign_in_ends = SignInEnds(self._database)
        self.puzzles = MadePuzzles(self._database)
        self.tags = Tags(self._database)
        self.trajectories = Trajectories(self._database, blobs, scratch, self._room)
        self._intake = UploadReceiver(blobs, max_bytes=settings.max_upload_bytes)
        lease_s = self._limits.lease_s
        leases = Leases(LeaseRows(self._database, lease_s) if self._database.is_shared else None, lease_s)
        common = CommonFiles(leases, None if settings.blobs is None else blobs)
        self._catalogue = Catalogue(LogRows(self._database), blobs, self._cache, root, common, self._forgotten)
        self._sample = Sample(self._cache, self._catalogue.picture(SAMPLE_ID))
        self._jobs = Jobs(self._catalogue, self._readers, self._room, leases)
        places = Places(self._limits, settings.max_upload_bytes, self._slots, self._room)
        self._uploads = Uploads(self._catalogue, self._intake, self._jobs, places)
        rows = JobRowsOfLogs(self._database, self.get)
        self.slam = LogJobs(rows, leases, self, new_worker, root / "slam", SlamKind())
        self.maps = ReferenceMaps(self, new_worker, root / "maps", self._room, common)
        kind = LocalizationKind(self.maps)
        self.localization = LogJobs(rows, leases, self, new_worker, root / "localization", kind)
        self.merges = LogJobs(rows, leases, self, new_worker, root / "merges", MergeKind())
        cluster = None if settings.fleet_executor is None else Cluster(settings.fleet_executor)
        at_once = settings.fleet_workers
        self.fleet = FleetJobs(rows, leases, self._catalogue, new_worker, at_once, cluster)
        self._job_queues = (self.slam, self.merges, self.localization, self.fleet)
        self._changes = Changes(
            self._database,
            logs=self._jobs.follow,
            links=self.links.follow,
            puzzles=self.puzzles.follow,
            log_tags=self.tags.follow,
            trajectories=self.trajectories.follow,
            jobs=self._follow_jobs,
            ended_sign_ins=self.sign_in_ends.follow,
        )
        self._folder = SharedFolder(settings.logs_dir, self._catalogue, self._jobs)
        reading, added = (self._jobs, self._readers), (self.tags, self.trajectories)
        self._visible = VisibleLogs(self._catalogue, self._folder, self._sample, reading, added)
        of_lookups = JobLimits(self._limits.read_timeout_s, self._limits.read_cpu_s, memory)
        self._inspections = Inspections(self._catalogue, of_lookups)
        self.scores = RelationScores(self._catalogue, scratch, of_lookups)
        self._pictures = MomentPictures(self._catalogue)
        self._fields = FieldLookups(self._catalogue, of_lookups)
        scans = Scans(self._catalogue, self._readers, self._cache, scratch)
        self._loading = Loading(self.get, self._catalogue, self._jobs, self._readers, self._sample, scans, self._cache)

    async def start(self) -> None:
        """Load the records of an earlier run, and handle its unfinished jobs and uploads.

        Raises :class:`StorageError`.
        """
        await self._folder.look()
        stores_match = await asyncio.to_thread(belong_together, self._database, self._blobs)
        await self._catalogue.start(stores_match=stores_match)
        for follow in (self.links.follow, self.puzzles.follow, self.tags.follow, self.sign_in_ends.follow):
            await follow()
        # As with blobs, the files may belong to another database, or this database may be new.
        await self.trajectories.start(may_delete=stores_match and bool(self._catalogue.all()))
        await self._expire()
        for record in self._catalogue.interrupted():
            self._jobs.resume(record)
        for queue in self._job_queues:
            await queue.start()
        self._folder.begin_survey()
        self._changes.begin()

    async def end_uploads(self) -> None:
        """Accept no further uploads, and wait until all running ones have ended."""
        await self._slots.close()

    async def close(self) -> None:
        """End the jobs and the reading processes, and close the stores."""
        await self._changes.close()
        await self._folder.close()
        for queue in self._job_queues:
            await queue.close()
        await self.maps.close()
        await self._jobs.close()
        await self._intake.close()
        await self._sample.close()
        await self._inspections.close()
        await self.scores.close()
        await self._pictures.close()
        await self._fields.close()
        if self._own_readers:
            await self._readers.close()
        await asyncio.to_thread(self._database.close)

    async def _expire(self) -> None:
        """Delete the uploads that have not been used for a long time."""
        await self._catalogue.expire(time.time() - self._limits.keep_s, self._jobs.busy)

    async def _forgotten(self, log_id: str) -> None:
        """Remove the additions to a deleted log."""
        for queue in self._job_queues:
            await queue.forget_log(log_id)
        await self.maps.forget_log(log_id)
        await self.trajectories.forget_log(log_id)
        self.tags.drop(log_id)
        self.puzzles.drop(log_id)

    async def _follow_jobs(self, log_ids: set[str] | None) -> None:
        """Load the changes of other services in the jobs on some logs, None: on any."""
        for queue in self._job_queues:
            await queue.follow(log_ids)

    def _room(self) -> int:
        """Return the number of bytes that uploads may still use on the disk."""
        used = self._catalogue.bytes + self.trajectories.total_bytes + self.maps.total_bytes
        return self._limits.max_total_bytes - used

    # -- uploads ------------------------------------------------------------------------------------------------

    def uploaded(self, owner: str, key: str) -> int:
        """Return the number of received bytes of the upload ``key`` of ``owner``, where the next part begins."""
        return self._intake.offset(owner, key)

    def forget_upload(self, owner: str, key: str) -> None:
        """Discard the received part of the upload ``key`` of ``owner``. An unknown one is no error."""
        self._intake.forget(owner, key)

    async def put(
        self,
        owner: str,
        name: str,
        chunks: AsyncIterator[bytes],
        size: int | None = None,
        *,
        sha256: str | None = None,
        address: str = "",
    ) -> Record:
        """Store an upload of ``owner``, queue it for reading and return its record.

        ``size`` is the size stated by the sender, so that an upload that is too large is refused at once; ``address``
        is the sender's, which has its share of the places. If the owner has uploaded the same bytes before, returns the
        existing record; if that failed, it is read again. Raises :class:`LimitError` for an upload over a cap and
        :class:`ReadError` for an empty one, and for one whose digest is not ``sha256``, and :class:`StorageError`; the
        upload is then removed.
        """
        record = await self._received(Sender(owner, address), Declared(name, size, sha256), chunks)
        assert record is not None  # noqa: S101 - for the type checker: without parts an upload is whole
        return record

    async def put_part(
        self,
        owner: str,
        name: str,
        chunks: AsyncIterator[bytes],
        part: Part,
        *,
        sha256: str | None = None,
        address: str = "",
    ) -> Record | None:
        """Store a part of an upload, like :meth:`put`; return the record once it is complete, None before.

        Data before an interruption is kept for a while. Raises :class:`UploadOffsetError` for a part with another
        offset.
        """
        return await self._received(Sender(owner, address), Declared(name, part.total, sha256, part), chunks)

    async def _received(self, sender: Sender, declared: Declared, chunks: AsyncIterator[bytes]) -> Record | None:
        self.check_stores()
        await self._expire()
        record = await self._uploads.receive(sender, declared, chunks)
        self.check_stores()  # no upload is confirmed whose record is in unlinked files
        return record

    def check_stores(self) -> None:
        """Raise :class:`StorageError` if the data folder or the database was moved, removed or made read-only."""
        self._known_paths.check()

    async def delete(self, owner: str, log_id: str) -> None:
        """Remove an upload of ``owner``: its bytes, its record and its pack. Sessions that use it continue.

        Raises :class:`LogNotFoundError`, :class:`StorageError`, and :class:`LogReadOnlyError` for a log that is not an
        upload.
        """
        record = self.get(owner, log_id)
        if record.source != "upload":
            raise LogReadOnlyError("log.read_only", "This log belongs to the server and cannot be deleted here.")
        await self._catalogue.delete(record.id)  # and its additions
        if await self._jobs.stop(record.id):
            for path in (self._catalogue.pack(record.id), self._catalogue.picture(record.id)):
                path.unlink(missing_ok=True)

    async def cancel(self, owner: str, log_id: str) -> Record:
        """Stop reading an upload of ``owner``, and return its record. It is kept and can be read again."""
        self._own_upload(owner, log_id)
        await self._jobs.stop(log_id)
        record = self._catalogue.get(log_id)
        if record is not None and record.state in ("queued", "reading"):
            failure = Failure("log.cancelled", "Reading was stopped.")
            self._catalogue.save(replace(record, state="failed", progress=0.0, error=failure))
        return self.get(owner, log_id)

    def read_again(self, owner: str, log_id: str) -> Record:
        """Queue a failed upload of ``owner`` for another reading; return its record."""
        record = self._own_upload(owner, log_id)
        return self._jobs.queue(replace(record, attempts=0)) if record.state == "failed" else record

    def _own_upload(self, owner: str, log_id: str) -> Record:
        record = self.get(owner, log_id)
        if record.source != "upload":
            raise LogReadOnlyError("log.read_only", "This log belongs to the server: how it is read cannot be changed.")
        return record

    # -- queries ------------------------------------------------------------------------------------------------

    async def list(self, owner: str) -> Sequence[Record]:
        """Return the logs that ``owner`` may open: own uploads (newest first), the folder's, the sample."""
        return await self._visible.list(owner)

    def files(self, owner: str) -> Sequence[Record]:
        """Return the logs with files that ``owner`` may open, as of the last scan of the folder."""
        return self._visible.files(owner)

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log that ``owner`` may open; raise :class:`LogNotFoundError` for any other."""
        return self._visible.get(owner, log_id)

    def pictured(self) -> AbstractSet[str]:
        """Return the ids of the logs of whose maps there are pictures; for a thread, see :meth:`Catalogue.pictured`."""
        return self._catalogue.pictured()

    async def map_picture(self, owner: str, log_id: str, *, dark: bool = False) -> bytes:
        """Return the picture of a log's map as PNG; see :meth:`VisibleLogs.picture`."""
        return await self._visible.picture(owner, log_id, dark=dark)

    # -- contents -----------------------------------------------------------------------------------------------

    async def load(self, owner: str, log_id: str, topic: str | None = None, cut: PlanarCut | None = None) -> ScanLog:
        """Return a log with the additions of ``owner``; wait for a running job.

        It comes from memory, from its pack, or from the reader. ``topic`` names the sensor if the log has several, or
        those to map together, separated by ``SEPARATOR``. By default it is the lidar with the most scans, or all
        sonars. ``cut`` has the options for cutting scans out of clouds and depth images. Raises
        :class:`LogNotFoundError`, the reader's errors (:class:`ReadError`, :class:`LimitError`), and
        :class:`ConfigError` for sensors that cannot be mapped together.
        """
        log = await self._loading.load(owner, log_id, topic, cut)
        return await self.trajectories.joined(owner, log_id, log)

    async def costmaps(self, owner: str, log_id: str) -> dict[str, CostmapStream] | None:
        """Return the costmaps of a recording without scans, by topic; None for other logs. Raises like :meth:`load`."""
        return await self._loading.costmaps(owner, log_id)

    async def volume(self, owner: str, log_id: str, topic: str | None = None) -> VolumeSource:
        """Return the source of a log's 3D map: the scans of its clouds, or an octree. Raises like :meth:`load`."""
        return await self._loading.volume(owner, log_id, topic)

    async def reference_map(self, owner: str, log_id: str) -> ReferenceMap | None:
        """Return the map of map files, named as their record; None for any other log. Raises like :meth:`load`."""
        return await self._loading.reference_map(owner, log_id)

    def opening(self, log_id: str) -> tuple[str, float | None]:
        """Return what :meth:`load` of a log currently waits for, in words, and its completed share, None if unknown."""
        return self._loading.opening(log_id)

    async def contents(self, owner: str, log_id: str, visitor: str, *, address: str = "") -> Contents | float:
        """Return the contents of a recording of ``owner``, or the completed share of reading them, from 0 to 1.

        Each call keeps the reading alive, and counts as ``visitor``'s. The sample is not a recording and has no
        contents. Raises :class:`LogNotFoundError`, and the reader's errors.
        """
        record = self.get(owner, log_id)
        if record.source == "sample":
            return Contents(())
        return await self._inspections.contents(record, visitor, address=address)

    def stop_inspecting(self, owner: str, log_id: str, visitor: str) -> None:
        """End what :meth:`contents` has started for ``visitor`` on a log of ``owner``.

        Raises :class:`LogNotFoundError`.
        """
        self._inspections.cancel(self.get(owner, log_id).id, visitor)

    async def add_trajectory(
        self, owner: str, log_id: str, name: str, chunks: AsyncIterator[bytes], *, address: str = ""
    ) -> tuple[Added, Sequence[str]]:
        """Add the TUM file in ``chunks`` to a log as one more trajectory; return its record, and notes.

        Raises like :meth:`load`, :func:`text_of` and :meth:`Trajectories.put` of its module.
        """
        log = await self.load(owner, log_id)
        async with self._slots.take(owner, address) as slot:
            text = await text_of(slot.read(chunks))
        return await self.trajectories.put(owner, self.get(owner, log_id), log, NewTrajectory(name, text))

    async def choose_map(
        self, owner: str, log_id: str, title: str, chunks: AsyncIterator[bytes], *, address: str = ""
    ) -> ReferenceMap:
        """Choose the map in uploaded files for localizing a log. Raises like :meth:`ReferenceMaps.of_files`."""
        async with self._slots.take(owner, address) as slot:
            return await self.maps.of_files(owner, log_id, title, slot.read(chunks), address=address)

    async def picture(
        self, owner: str, log_id: str, visitor: str, topic: str, at_ns: int, *, address: str = ""
    ) -> MomentPicture:
        """Return a picture of an image or a cloud in a log of ``owner``; see :meth:`MomentPictures.picture`."""
        return await self._pictures.picture(self.get(owner, log_id), visitor, topic, at_ns, address=address)

    async def fields(
        self, owner: str, log_id: str, visitor: str, topics: Sequence[tuple[str, str]], *, address: str = ""
    ) -> Sequence[TopicFields] | float:
        """Return the fields of the messages in a log of ``owner``; see :meth:`FieldLookups.names`."""
        return await self._fields.names(self.get(owner, log_id), visitor, topics, address=address)

    async def field_series(
        self, owner: str, log_id: str, visitor: str, topic: str, kind: str, *, address: str = ""
    ) -> Series | float:
        """Return the numbers of a topic of a log of ``owner``; see :meth:`FieldLookups.series`."""
        return await self._fields.series(self.get(owner, log_id), visitor, topic, kind, address=address)

    async def message(
        self, owner: str, log_id: str, visitor: str, topic: str, at_ns: int, *, address: str = ""
    ) -> RawMessage:
        """Return the fields of a message in a log of ``owner``; see :meth:`MomentPictures.message`."""
        return await self._pictures.message(self.get(owner, log_id), visitor, topic, at_ns, address=address)
