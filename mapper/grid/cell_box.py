"""A rectangle of cells."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CellBox:
    """The cells [row0, row1) × [col0, col1)."""

    row0: int
    row1: int
    col0: int
    col1: int

    def __or__(self, other: CellBox) -> CellBox:
        """Return the smallest box that contains both."""
        return CellBox(
            min(self.row0, other.row0),
            max(self.row1, other.row1),
            min(self.col0, other.col0),
            max(self.col1, other.col1),
        )

    def padded(self, by: int, rows: int, cols: int) -> CellBox:
        """Return the box enlarged by ``by`` cells on each side, clipped to a grid of ``rows`` × ``cols`` cells."""
        return CellBox(
            max(self.row0 - by, 0), min(self.row1 + by, rows), max(self.col0 - by, 0), min(self.col1 + by, cols)
        )
