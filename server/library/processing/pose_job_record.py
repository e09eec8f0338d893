"""The record of a job that gives a log another trajectory."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from server.library.processing.job_record import JobRecord


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseJobRecord(JobRecord):
    """A job that makes poses of a log from those of ``trajectory``.

    ``parameters`` are the kind's own, as its ``checked`` returns them, ``cut`` how the scans are cut out of clouds and
    depth images (None: as by default), ``mapping`` the parameters of the map that the poses are for (None: as by
    default): the job uses its mount and its time offset.
    """

    trajectory: str | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    cut: dict[str, float] | None = None
    mapping: dict[str, Any] | None = None

    def public(self) -> dict[str, Any]:
        """Return what the HTTP interface shows."""
        return {
            "log": self.log_id,
            "topic": self.topic,
            "odometry": self.trajectory,
            "parameters": self.parameters,
            "state": self.state,
            "created_s": self.created_s,
            "error": None if self.error is None else asdict(self.error),
            "result": self.result,
        }
