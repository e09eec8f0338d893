"""The comparison of a session's 3D map with that of another file, or with an earlier state."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.volume import OctreeFile, VolumeConfig, changes_between
from mapper.volume.occupancy.changes import Changes
from mapper.volume.scans.replayed import ReplayedVolume
from server.stream.message_parts import VolumeChanges

if TYPE_CHECKING:
    from server.library.packs.volume import VolumeSource
    from server.parts.volume.drawings import VolumeDrawings
    from server.sessions.tick import TickResult

SLICE_S = 0.1  #: longest run of computing the other map before other work gets its turn


class VolumeComparison:
    """The other map, if there is one, and the differences.

    ``other`` is the title and the source of a map that is computed with the parameters of the session's map.
    """

    def __init__(self, other: tuple[str, VolumeSource] | None, limits: Callable[[], Limits]) -> None:
        self._other, self._limits = other, limits
        self._map: ReplayedVolume | None = None
        self._title = ""
        self.changes: Changes | None = None
        self.is_stale = other is not None

    @property
    def n_cells(self) -> int:
        """Number of voxels for which the other map has memory."""
        return 0 if self._map is None else self._map.n_cells

    def note_change(self) -> None:
        """Record that the session's map has changed."""
        self.is_stale = self._map is not None or self._other is not None

    def keep(self, now: ReplayedVolume) -> None:
        """Compare with a copy of the current map."""
        self.end()
        volume = ReplayedVolume(now.source, now.config, self._limits)
        volume.volume.set_blocks(now.volume.blocks.codes.copy(), now.volume.values)
        volume.index = volume.count  # it is not recomputed
        self._map, self._title, self.is_stale = volume, f"the map of {now.index} scans", True

    def end(self) -> None:
        """End the comparison."""
        self._other, self._map, self.changes, self.is_stale = None, None, None, False

    def work(self, now: ReplayedVolume, may_continue: Callable[[], bool]) -> bool:
        """Compute a part of the other map, and then the differences; return whether that is finished.

        Raises :class:`mapper.core.errors.MapperError` for maps that cannot be compared, and ends the comparison.
        """
        if self._other is not None and (self._map is None or self._differs(now.config)):
            self._title, source = self._other
            own = VolumeConfig(source.tree.resolution) if isinstance(source, OctreeFile) else now.config
            self._map = ReplayedVolume(source, own, self._limits)
        other, began = self._map, time.monotonic()
        if other is not None and not other.go_to(other.count, lambda: time.monotonic() - began > SLICE_S, may_continue):
            return False
        self.is_stale = False
        self.changes = None if other is None else changes_between(other.volume, now.volume)
        return True

    def update(
        self, now: ReplayedVolume, drawn: VolumeDrawings, may_continue: Callable[[], bool], result: TickResult
    ) -> None:
        """Do a part of the work, and draw the differences once they are known. An impossible comparison is ended."""
        try:
            if self.work(now, may_continue):
                drawn.show_changes(self.changes, now.config.resolution)
        except WorkCancelledError:
            return
        except MapperError as error:
            self.end()
            result.notice(error.code, error.message)

    def _differs(self, config: VolumeConfig) -> bool:
        other = self._map
        return other is not None and not isinstance(other.source, OctreeFile) and other.config != config

    def summary(self) -> VolumeChanges | None:
        """Return the field ``compared`` of the ``volume`` message."""
        changes = self.changes
        if changes is None:
            return None
        return VolumeChanges(
            title=self._title,
            appeared=len(changes.appeared),
            vanished=len(changes.vanished),
            same=changes.same,
            only_first=changes.only_first,
            only_second=changes.only_second,
        )
