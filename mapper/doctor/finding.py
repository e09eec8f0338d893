"""What an examination says: one finding for each thing that is wrong, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Finding:
    """Something about a log that makes its map worse.

    ``check`` is the stable name of the check; ``sentence`` says what was found and ``advice`` what to do about it, one
    sentence each; ``sure`` is 0 … 1; ``scans`` are the first places, as scan numbers, at which it shows, and
    ``parameters`` the values of :data:`mapper.parameters.PARAMETERS` that would help, if any do.
    """

    check: str
    sentence: str
    advice: str
    sure: float
    scans: tuple[int, ...] = ()
    parameters: dict[str, Any] | None = None


MOST_SCANS = 20  #: places that a finding names
