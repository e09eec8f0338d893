"""What sessions use of the budgets of a service, also those of its other workers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Use:
    """Numbers of sessions, cells of their grids, and bytes of their logs; ``guests``: of those alone."""

    sessions: int = 0
    guests: int = 0
    cells: int = 0
    guests_cells: int = 0
    log_bytes: int = 0


class OthersUse(Protocol):
    """What the sessions of the other workers of a service use together."""

    def others(self) -> Use:
        """Return it."""

    def state(self, own: Use) -> None:
        """State what the sessions of this worker use."""
