"""Logs that a visitor may open, and their entries in lists. Used from the event loop."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from server.library.logs.catalogue import Catalogue
from server.library.logs.errors import LogNotFoundError
from server.library.logs.records import Record
from server.library.logs.sample import SAMPLE_ID, Sample
from server.library.processing.reader import Readers
from server.library.processing.reading_jobs import Jobs
from server.library.shared_folder import SharedFolder

if TYPE_CHECKING:
    from server.library.annotations.tags import Tags
    from server.library.annotations.trajectories import Trajectories


class VisibleLogs:
    """Own uploads, the logs of the folder, and the sample, each with what its visitor has added to it."""

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
        records = [*self._uploads(owner), *self._folder.records(), self._sample.record]
        return [self._as_seen_by(owner, record) for record in records]

    def files(self, owner: str) -> Sequence[Record]:
        """Return the logs with files that ``owner`` may open, as at the last look into the folder."""
        return [*self._uploads(owner), *self._folder.records()]

    def _uploads(self, owner: str) -> Sequence[Record]:
        own = (record for record in self._catalogue.uploaded() if record.owner == owner)
        return sorted(own, key=lambda record: record.created_s, reverse=True)

    def get(self, owner: str, log_id: str) -> Record:
        """Return the record of a log that ``owner`` may open; raise :class:`LogNotFoundError` for any other."""
        if log_id == SAMPLE_ID:
            self._sample.begin()  # of several processes of the service, each makes it
            return self._as_seen_by(owner, self._sample.record)
        record = self._catalogue.get(log_id)
        if log_id in self._catalogue.folder_logs:
            record = self._folder.record(self._catalogue.folder_logs[log_id])
        elif record is not None and (record.source == "folder" or record.owner != owner):  # gone, or another's
            record = None
        if record is None:
            raise LogNotFoundError("log.not_found", "There is no such log.")
        return self._as_seen_by(owner, record)

    def _as_seen_by(self, owner: str, record: Record) -> Record:
        """Return a record with the present progress, and with what ``owner`` has added to the log."""
        is_read = record.state == "reading"
        progress = self._jobs.progress(record) if is_read else record.progress
        reading_s = self._readers.of(record).elapsed_s if is_read else None
        added = tuple(one.public() for one in self._trajectories.of(owner, record.id))
        has_picture = record.state == "ready" and self._catalogue.picture(record.id).exists()
        tags = self._tags.of(owner, record.id)
        return replace(record, progress=progress, reading_s=reading_s, has_picture=has_picture, tags=tags, added=added)

    async def picture(self, owner: str, log_id: str, *, dark: bool = False) -> bytes:
        """Return the picture of a log's map as PNG, in the colours of a light or a dark page.

        Raises :class:`LogNotFoundError`, also where there is no picture.
        """
        from server.library.packs.picture import read_picture  # noqa: PLC0415 - Pillow and the replay of logs

        record = self.get(owner, log_id)
        await self._catalogue.fetch(record.id)
        try:
            return await asyncio.to_thread(read_picture, self._catalogue.picture(record.id), dark=dark)
        except OSError:
            raise LogNotFoundError("log.no_picture", "There is no picture of this log’s map yet.") from None
