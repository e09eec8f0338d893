"""Findings of an examination: one for each defect, with its location in the log."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

POSSIBLE = 0.7  #: confidence required for a finding to be stated as a fact


@dataclass(frozen=True, slots=True)
class Finding:
    """A property of a log that degrades its map.

    ``check`` is the stable name of the check; ``sentence`` states the finding and ``advice`` the remedy, one sentence
    each; ``sure`` is the confidence, 0 to 1; ``scans`` are the indices of the first scans affected, and ``parameters``
    the values of :data:`mapper.mapping.parameters.PARAMETERS` that would help, if any. ``sensor`` is the topic of the
    sensor concerned if a log of several was examined, else empty.
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
        """Whether the finding is stated as possible only, because its confidence is below :data:`POSSIBLE`."""
        return self.stated_sure < POSSIBLE

    @property
    def stated_sure(self) -> float:
        """The confidence as stated, in whole percent, which is compared with :data:`POSSIBLE`."""
        return round(self.sure, 2)

    def public(self) -> dict[str, Any]:
        """Return the fields and ``possible``, for JSON."""
        return {**asdict(self), "possible": self.possible}


MOST_SCANS = 20  #: maximum number of scans that a finding lists
