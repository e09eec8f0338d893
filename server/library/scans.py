"""The scans of logs: from memory, from their packs, or, for another sensor, by reading the file again."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mapper.core.errors import MapperError
from mapper.io.logs.summary import summarise
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.library.logs.cache import LogCache
from server.library.logs.catalogue import Catalogue
from server.library.logs.records import Record
from server.library.packs.log import NotPackedError, StalePackError, read_pack
from server.library.processing.reader import Readers
from server.library.processing.reading_jobs import unreadable, without_paths

if TYPE_CHECKING:
    from server.library.packs.volume import VolumeSource


class Scans:
    """The scans of the catalogue's logs; ``scratch`` is a folder for temporary packs."""

    def __init__(self, catalogue: Catalogue, readers: Readers, cache: LogCache, scratch: Path) -> None:
        self._catalogue = catalogue
        self._readers = readers
        self._cache = cache
        self._scratch = scratch
        self._unpacking = asyncio.Lock()
        self.read_now: set[str] = set()  #: logs whose files are being read for one of their sensors

    async def packed(self, record: Record) -> ScanLog:
        """Return the log in its pack. Raises :class:`StalePackError` for a missing or outdated pack."""
        async with self._unpacking:  # concurrent callers share the log, and only one is unpacked at a time
            cached = self._cache.get(record.id)
            if cached is not None:
                return cached
            await self._catalogue.fetch(record.id)
            log = await asyncio.to_thread(read_pack, self._catalogue.pack(record.id))
            log = replace(log, name=record.name)
            self._cache.put(record.id, log)
        if record.summary is None:
            self._catalogue.save(replace(record, state="ready", progress=1.0, summary=summarise(log)))
        return log

    async def of_clouds(self, record: Record, topic: str | None) -> VolumeSource:
        """Return the clouds of a recording, those of ``topic`` or of its first topic, read on request.

        Raises :class:`ReadError` for a file without clouds.
        """
        from server.library.packs.volume import read_volume_pack  # noqa: PLC0415 - few logs have clouds

        async with self._readers.of(record).turn(record.owner):
            pack = self._scratch / f"{secrets.token_hex(10)}.npz"
            try:
                await self._read_now(record, pack, topic, volume=True)
                return await asyncio.to_thread(read_volume_pack, pack)
            except StalePackError:
                raise unreadable() from None
            finally:
                for half in self._scratch.glob(f"{pack.name}*"):
                    half.unlink(missing_ok=True)

    async def _read_now(
        self, record: Record, pack: Path, topic: str | None, cut: PlanarCut | None = None, *, volume: bool = False
    ) -> None:
        """Have a log read into ``pack``; the caller holds the reader's turn."""
        async with self._catalogue.source(record) as source:
            self.read_now.add(record.id)
            try:
                await self._readers.of(record).read(source, pack, topic, cut, volume=volume)
            except MapperError as error:
                raise without_paths(error, source, record.name) from None
            finally:
                self.read_now.discard(record.id)

    async def of_sensor(self, record: Record, topic: str, cut: PlanarCut | None = None) -> ScanLog:
        """Return one of several sensors: from the pack, otherwise read on request, and then cached only in memory.

        ``cut`` has the options for cutting its scans out of clouds or depth images; the pack's scans use the defaults.
        """
        key = f"{record.id}#{topic}#{'' if cut is None else cut.values}"
        async with self._unpacking:
            cached = self._cache.get(key)
            if cached is not None:
                return cached
            if cut is None:
                await self._catalogue.fetch(record.id)
                with suppress(StalePackError, NotPackedError):
                    log = await asyncio.to_thread(read_pack, self._catalogue.pack(record.id), topic)
                    log = replace(log, name=record.name)
                    self._cache.put(key, log)
                    return log
        async with self._readers.of(record).turn(record.owner):
            cached = self._cache.get(key)
            if cached is not None:
                return cached
            pack = self._scratch / f"{secrets.token_hex(10)}.npz"
            try:
                await self._read_now(record, pack, topic, cut)
                log = replace(await asyncio.to_thread(read_pack, pack), name=record.name)
            except StalePackError:
                raise unreadable() from None
            finally:
                for half in self._scratch.glob(f"{pack.name}*"):
                    half.unlink(missing_ok=True)
            self._cache.put(key, log)
        return log
