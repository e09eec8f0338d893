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
        """Return the smallest box that holds both."""
        return CellBox(
            min(self.row0, other.row0),
            max(self.row1, other.row1),
            min(self.col0, other.col0),
            max(self.col1, other.col1),
        )
