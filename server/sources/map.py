"""The model of a session that shows a map, which a part edits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from server.library.packs.reference_map import ReferenceMap
from server.parts import parts_of
from server.sessions.hosting import ModelHost
from server.sessions.model import NO_READINGS, Footprint, SessionModel
from server.sessions.part import Offers
from server.sessions.parts import EditedFiles
from server.sessions.tick import TickResult
from server.sessions.view import Playback
from server.stream.layers import Layer
from server.stream.messages import FrameMessage, ScanFields


class MapModel(SessionModel):
    """A map of the library."""

    kind: ClassVar[str] = "map"

    def __init__(self, host: ModelHost, reference: ReferenceMap) -> None:
        """Show a map. Raises :class:`mapper.core.errors.LimitError` if it is too large to edit."""
        super().__init__(Playback(playing=False))
        self._given = reference
        self.parts = parts_of(Offers(host, map=reference))

    @property
    def layers(self) -> Sequence[Layer]:
        """The layers of the parts."""
        return [layer for part in self.parts_on for layer in part.layers]

    @property
    def title(self) -> str:
        """The name of the map."""
        return self._given.title

    @property
    def footprint(self) -> Footprint:
        """Number of cells of the parts."""
        return Footprint(sum(part.cells for part in self.parts))

    @property
    def progress(self) -> tuple[int, int]:
        """The map is complete."""
        return (1, 1)

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the centre of the map as the pose, because the keyboard cursor starts there."""
        edited = self.find(EditedFiles)
        geometry = self._given.geometry if edited is None else edited.geometry
        x, y = geometry.cell_to_world(((geometry.rows - 1) // 2, (geometry.cols - 1) // 2)).round(4).tolist()
        frame.pose = (x, y, 0.0)

    def scan(self) -> ScanFields:
        """Return a scan without readings."""
        return NO_READINGS

    def advance(self, dt: float, result: TickResult) -> None:
        """Do nothing, because a map does not change with time."""
