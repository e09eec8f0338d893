"""Findings of an examination: one for each defect, with its place in the log."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

POSSIBLE = 0.7  #: how sure a finding has to be to be stated as a fact


@dataclass(frozen=True, slots=True)
class Finding:
    """Something about a log that makes its map worse.

    ``check`` is the stable name of the check; ``sentence`` says what was found and ``advice`` what to do about it, one
    sentence each; ``sure`` is 0 … 1; ``scans`` are the first places, as scan numbers, at which it shows, and
    ``parameters`` the values of :data:`mapper.mapping.parameters.PARAMETERS` that would help, if any do. ``sensor`` is
    the topic of the sensor that it is about, where a log of several was examined, else empty.
    """

    check: str
    sentence: str
    advice: str
    sure: float
    scans: tuple[int, ...] = ()
    parameters: dict[str, Any] | None = None
    sensor: str = ""

    @property
    def possible(self) -> bool:
        """Whether the finding is to be stated as possible only: it is less sure than :data:`POSSIBLE`."""
        return self.stated_sure < POSSIBLE

    @property
    def stated_sure(self) -> float:
        """How sure it is, as it is stated: in whole percent. It is this that is compared with :data:`POSSIBLE`."""
        return round(self.sure, 2)

    def public(self) -> dict[str, Any]:
        """Return the fields and ``possible``, for JSON."""
        return {**asdict(self), "possible": self.possible}


MOST_SCANS = 20  #: places that a finding names
