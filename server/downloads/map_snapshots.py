"""Named snapshots of maps, kept for a while, so that map.yaml and map.pgm describe the same map."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

from mapper.core.errors import MapperError
from mapper.grid import GridGeometry
from mapper.sensors.georeference import NO_OFFSET, Offset
from server.downloads.compressed_image import CompressedImage

MAX_KEPT_BYTES = 64 << 20  #: of all sessions
MAX_KEPT = 4  #: maps of one session
MAX_NAMES = 256  #: of one session whose geometry is still known


class MapSnapshotGoneError(MapperError):
    """The image of a named snapshot is no longer stored."""


@dataclass(frozen=True, slots=True)
class MapSnapshot:
    """A map at one instant: the name of its files, its geometry, its image and its frame (None: unknown).

    ``offset`` (x, y) is to be added to the geometry's origin.
    """

    stem: str
    geometry: GridGeometry
    image: CompressedImage | None  #: None once it is no longer stored
    frame: str | None = None
    offset: Offset = NO_OFFSET


@dataclass(slots=True, eq=False)
class _Entry:
    made: asyncio.Lock = field(default_factory=asyncio.Lock)
    snapshot: MapSnapshot | None = None


class SnapshottedSession(Protocol):
    """The interface of a session that is used here."""

    id: str
    closed: bool
    on_close: list[Callable[[], None]]


class MapSnapshots:
    """The named snapshots of all sessions. Used on the event loop only."""

    def __init__(self) -> None:
        self._sessions: dict[str, dict[str, _Entry]] = {}

    async def get(
        self, session: SnapshottedSession, name: str, make: Callable[[], Awaitable[MapSnapshot]]
    ) -> MapSnapshot:
        """Return a session's snapshot ``name``; if the name is new, the result of ``make``."""
        if session.id not in self._sessions:
            self._sessions[session.id] = {}
            session.on_close.append(lambda: self._forget(session.id))
        entries = self._sessions[session.id]
        while name not in entries and len(entries) >= MAX_NAMES:
            del entries[next(iter(entries))]
        entry = entries.setdefault(name, _Entry())
        async with entry.made:
            if entry.snapshot is None:
                entry.snapshot = await make()
                self._bound(entries)
                if session.closed:
                    self._forget(session.id)
            return entry.snapshot

    def _forget(self, session: str) -> None:
        self._sessions.pop(session, None)

    @property
    def nbytes(self) -> int:
        """Bytes of all stored images."""
        return sum(_nbytes(entries) for entries in self._sessions.values())

    def _bound(self, newest: dict[str, _Entry]) -> None:
        """Drop the oldest images of the session with the most bytes until the limits hold."""
        while len(_with_data(newest)) > MAX_KEPT:
            _drop_oldest(newest)
        while self.nbytes > MAX_KEPT_BYTES:
            _drop_oldest(max(self._sessions.values(), key=_nbytes))


def _with_data(entries: dict[str, _Entry]) -> list[_Entry]:
    return [entry for entry in entries.values() if entry.snapshot is not None and entry.snapshot.image is not None]


def _nbytes(entries: dict[str, _Entry]) -> int:
    images = [entry.snapshot.image for entry in entries.values() if entry.snapshot is not None]
    return sum(image.nbytes for image in images if image is not None)


def _drop_oldest(entries: dict[str, _Entry]) -> None:
    entry = _with_data(entries)[0]
    assert entry.snapshot is not None  # noqa: S101 - for the type checker: it is kept
    entry.snapshot = replace(entry.snapshot, image=None)
