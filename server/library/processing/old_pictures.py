"""Pictures of the maps of logs that were read before pictures were drawn, or whose picture was lost."""

from __future__ import annotations

import asyncio
import contextlib

import structlog

from mapper.core.errors import MapperError
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.processing.reader import Reader
from server.storage import StorageError

_log = structlog.get_logger(__name__)

#: Greatest number of pictures drawn after one start: each log is read again for its own.
MOST = 500


class OldPictures:
    """Draws the missing pictures in the background, one log after the other. Used from the event loop."""

    def __init__(self, catalogue: Catalogue, reader: Reader) -> None:
        self._catalogue = catalogue
        self._reader = reader
        self._job: asyncio.Task[None] | None = None

    def begin(self) -> None:
        """Begin with the logs that have no picture, the newest first."""
        without = [record for record in self._catalogue.all() if self._lacks(record)]
        newest = sorted(without, key=lambda record: record.created_s, reverse=True)[:MOST]
        if newest:
            self._job = asyncio.create_task(self._draw(newest))

    async def close(self) -> None:
        """Stop drawing; the next start goes on."""
        if self._job is not None:
            self._job.cancel()
            await asyncio.gather(self._job, return_exceptions=True)

    def _lacks(self, record: Record) -> bool:
        if record.state != "ready" or (record.source == "folder" and record.id not in self._catalogue.folder_logs):
            return False
        return not (self._catalogue.picture(record.id).exists() or self._catalogue.no_picture(record.id).exists())

    async def _draw(self, records: list[Record]) -> None:
        for record in records:
            await self._catalogue.fetch(record.id)
            # Between two of them other waiting jobs have a turn, as all logs are read one after the other.
            async with self._reader.turn(record.owner):
                now = self._catalogue.get(record.id)
                if now is None or not self._lacks(now):
                    continue
                picture = self._catalogue.picture(record.id)
                try:
                    async with self._catalogue.source(now) as source:
                        await self._reader.read(source, None, picture=picture)
                except (MapperError, StorageError, OSError, KeyError) as error:
                    _log.info("no picture of a log", log=record.id, error=str(error))
                await self._catalogue.publish(record.id)
                if self._catalogue.get(record.id) is None:  # deleted meanwhile
                    picture.unlink(missing_ok=True)
                elif not picture.exists():  # nothing of it can be drawn: it is not read again at each start
                    with contextlib.suppress(OSError):
                        self._catalogue.no_picture(record.id).touch()
