"""Files of logs in the store of blobs, where every service finds them: packs, pictures, and maps for localization.

A service that does not share its database and store keeps them only in its data folder.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from pathlib import Path

from server.jobs.leases import Leases
from server.library.store.blobs import Blobs
from server.storage import StorageError

PACKS = "packs"  #: the folder of the store
MIN_AGE_S = 24 * 3600.0  #: of files without a record; younger ones may belong to an upload elsewhere


class CommonFiles:
    """Copies files to and from ``blobs``, None: nowhere. ``leases`` are those of the services that share them."""

    def __init__(self, leases: Leases, blobs: Blobs | None) -> None:
        self._leases = leases
        self._files = blobs.beside(PACKS) if blobs is not None and leases.is_shared else None
        self._fetching = asyncio.Lock()

    @property
    def is_shared(self) -> bool:
        """Whether other services may use the records and the blobs."""
        return self._leases.is_shared

    @property
    def min_age_s(self) -> float:
        """Age in seconds above which a file without a record is removed."""
        return MIN_AGE_S if self.is_shared else 0.0

    @asynccontextmanager
    async def alone(self, sha256: str | None) -> AsyncIterator[None]:
        """Wait until no other service adds or deletes the blob, and hold it; None: nothing is held."""
        if sha256 is None or not self.is_shared:
            yield
            return
        async with self._leases.alone(f"blob {sha256}"):
            yield

    async def fetch(self, *paths: Path) -> None:
        """Copy missing files from the store; those not in the store stay missing."""
        if self._files is None:
            return
        async with self._fetching:
            for path in paths:
                if not path.exists():
                    with contextlib.suppress(StorageError):
                        await self._files.copy_out(path.name, path)

    async def publish(self, *paths: Path) -> None:
        """Copy existing files into the store. Data of files that cannot be copied is read again elsewhere."""
        if self._files is None:
            return
        for path in paths:
            if path.exists():
                with contextlib.suppress(StorageError):
                    await self._files.copy_in(path, path.name)

    async def replace(self, path: Path, name: str) -> None:
        """Copy a file into the store, replacing an older one of this name. Raises :class:`StorageError`."""
        if self._files is not None:
            await self._files.copy_in(path, name)

    async def update(self, path: Path, name: str) -> None:
        """Replace a local file by the store's file of this name, if the store has it and is reachable."""
        if self._files is not None:
            with contextlib.suppress(StorageError):
                await self._files.copy_out(name, path)

    async def delete(self, *names: str) -> None:
        """Remove the files of these names from the store."""
        if self._files is not None:
            for name in names:
                await self._files.delete(name)

    async def remove_unreferenced(self, log_ids: Collection[str]) -> None:
        """Remove the files of other logs from the store."""
        if self._files is not None:
            for name in await self._files.names(MIN_AGE_S):
                if name.partition(".")[0] not in log_ids:
                    await self._files.delete(name)
