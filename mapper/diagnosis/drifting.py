"""Check one trajectory for drift; commands that make a map report this finding with it."""

from __future__ import annotations

from mapper.diagnosis.consistency import examined_as_mapped
from mapper.diagnosis.examination import LEAST_SCANS
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.walls import check_drift
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


def drift_finding(log: ScanLog, trajectory: str | None, config: MappingConfig) -> Finding | None:
    """Return the drift finding of ``trajectory`` (None: the log's default), or None where there is none.

    ``config`` gives the correction of the mount, the time offset and the largest range, metres. At most
    :data:`mapper.diagnosis.consistency.MOST_READINGS` readings are looked at, however long the log is. Raises
    :class:`ConfigError` for a trajectory that the log lacks.
    """
    whole, seen = examined_as_mapped(log, trajectory, config)
    if log.n_scans < LEAST_SCANS:
        return None
    found = check_drift(whole, seen)
    return found[0] if found else None
