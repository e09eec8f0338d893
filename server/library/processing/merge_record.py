"""The record of a job that merges two logs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from server.library.processing.job_record import JobRecord


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeRecord(JobRecord):
    """A job that merges a log with the log ``other``, whose sensor ``other_topic`` names.

    ``cut`` and ``other_cut`` say how the scans of each are cut out of clouds and depth images (None: as by default).
    """

    other: str = ""
    other_topic: str | None = None
    cut: dict[str, float] | None = None
    other_cut: dict[str, float] | None = None

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {
            "state": self.state,
            "other": self.other or None,
            "error": None if self.error is None else asdict(self.error),
            "result": self.result,
        }
