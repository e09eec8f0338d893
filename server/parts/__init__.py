"""The parts of sessions: the one list that names them. Their messages are in the unions of :mod:`server.stream`."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from server.sessions.part import Offers, Part


def parts_of(offers: Offers) -> list[Part]:
    """Return the parts that have what they need, in the order in which they follow the source."""
    from server.parts.costmap.part import CostmapPart  # noqa: PLC0415 - imported with the first session
    from server.parts.path.part import PathPart  # noqa: PLC0415
    from server.parts.terrain.part import TerrainPart  # noqa: PLC0415

    made = (made_by(offers) for made_by in (TerrainPart.of, CostmapPart.of, PathPart.of))
    return [part for part in made if part is not None]
