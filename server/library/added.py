"""A trajectory that a visitor has added to a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from mapper.core.errors import MapperError

TrajectorySource = Literal["tum", "slam", "localized"]


class TrajectoryNotFoundError(MapperError):
    """The visitor has added no such trajectory to the log."""


@dataclass(frozen=True, slots=True)
class Added:
    """One trajectory beside a log, seen by its ``owner`` only and by guests of the owner's links.

    ``source`` says where it comes from: an uploaded TUM file, or the service's own SLAM or localization. ``bytes`` are
    those of its files, ``poses`` the number of poses in them, ``length_m`` the length of the path, metres.
    """

    id: str
    owner: str
    log_id: str
    name: str
    description: str
    source: TrajectorySource
    created_s: float
    bytes: int
    poses: int
    length_m: float
    has_graph: bool = False  #: whether the pose graph that it was computed with is kept too

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {
            "name": self.name,
            "description": self.description,
            "length_m": self.length_m,
            "source": self.source,
            "created_s": self.created_s,
            "has_graph": self.has_graph,
        }
