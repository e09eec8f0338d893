"""One scan in the frame of a map."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.array_types import Float64Array


@dataclass(frozen=True, slots=True)
class PlacedScan:
    """Points (n, 3) in the map's frame, metres, at ``stamp_ns``; ``origin`` (3,) is None if unknown."""

    points: Float64Array
    origin: Float64Array | None
    stamp_ns: int = 0
