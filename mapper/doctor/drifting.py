"""Whether the poses of one trajectory drift, as one finding: what a command can say beside a map that it made."""

from __future__ import annotations

from mapper.doctor.consistency import examined
from mapper.doctor.examination import LEAST_SCANS
from mapper.doctor.finding import Finding
from mapper.doctor.walls import check_drift
from mapper.parameters import MappingConfig
from mapper.scan import ScanLog


def drift_finding(log: ScanLog, trajectory: str | None, config: MappingConfig) -> Finding | None:
    """Return the drift finding of ``trajectory`` (None: the log's default), or None where there is none.

    ``config`` gives the mount correction and the maximum range. Raises :class:`ConfigError` for a trajectory that the
    log lacks.
    """
    if log.n_scans < LEAST_SCANS:
        return None
    seen = examined(log, trajectory)
    found = check_drift(log, seen)
    return next((finding for finding in found if finding.check == "walls.drift"), None)
