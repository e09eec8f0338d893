"""The shared folder of logs: its current contents, and a survey that reads its logs one by one."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Sequence
from pathlib import Path

from server.library.logs.catalogue import Catalogue
from server.library.logs.folder import FolderLog, LogFolder
from server.library.logs.records import Record, display_name
from server.library.processing.reading_jobs import Jobs
from server.storage import StorageError


class SharedFolder:
    """The logs in ``path``, None for no folder, in the catalogue. Used from the event loop."""

    def __init__(self, path: Path | None, catalogue: Catalogue, jobs: Jobs) -> None:
        self._folder = None if path is None else LogFolder(path)
        self._catalogue = catalogue
        self._jobs = jobs
        self._looking = asyncio.Lock()  #: held while the folder is scanned
        self._survey_job: asyncio.Task[None] | None = None

    async def close(self) -> None:
        """End the survey."""
        if self._survey_job is not None:
            self._survey_job.cancel()
            await asyncio.gather(self._survey_job, return_exceptions=True)

    def records(self) -> Sequence[Record]:
        """Return the records of the logs in the folder."""
        return [self.record(log) for log in self._catalogue.folder_logs.values()]

    async def look(self) -> None:
        """Update the records from the folder's current contents; remove logs that are gone."""
        if self._folder is None:
            return
        async with self._looking:
            self._catalogue.folder_logs = {log.id: log for log in await asyncio.to_thread(self._folder.logs)}
        gone = [r for r in self._catalogue.all() if r.source == "folder" and r.id not in self._catalogue.folder_logs]
        for record in gone:
            if record.id not in self._jobs.busy:
                with contextlib.suppress(StorageError):  # next time
                    await self._catalogue.delete(record.id)

    def record(self, log: FolderLog) -> Record:
        """Return the record of one of its logs."""
        known = self._catalogue.get(log.id)
        if known is not None:
            return known
        return Record(log.id, "", display_name(log.name), "folder", "queued", log.bytes, created_s=log.modified_s)

    def _unknown(self) -> Record | None:
        """Return an unread log; None if there is none."""
        known = self._catalogue.all()
        ids = {record.id for record in known}
        folder = (self.record(log) for log in self._catalogue.folder_logs.values() if log.id not in ids)
        unsaid = (record for record in known if record.state == "ready" and record.summary is None)
        return next(folder, None) or next(unsaid, None)

    def begin_survey(self) -> None:
        """Start the survey of unread logs, unless it is complete or running."""
        if self._survey_job is None and self._unknown() is not None:
            self._survey_job = asyncio.create_task(self._survey())

    async def _survey(self) -> None:
        """Read the unread logs one after the other, so that a visitor waits for at most one of them.

        They are not packed, because a folder may be larger than the room for packs.
        """
        try:
            while (record := self._unknown()) is not None:
                self._jobs.queue(record, pack=False)
                await self._jobs.settled(record.id)
        finally:
            self._survey_job = None
