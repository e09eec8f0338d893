"""Check one trajectory for drift; commands that make a map report this finding with it."""

from __future__ import annotations

from dataclasses import replace

from mapper.diagnosis.consistency import examined
from mapper.diagnosis.examination import LEAST_SCANS
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.walls import check_drift
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog

_OF_THE_MAP = ("mount_x", "mount_y", "mount_yaw", "mount_upside_down")


def drift_finding(log: ScanLog, trajectory: str | None, config: MappingConfig) -> Finding | None:
    """Return the drift finding of ``trajectory`` (None: the log's default), or None where there is none.

    ``config`` gives the correction of the mount, the time offset and the largest range, metres. At most
    :data:`mapper.diagnosis.consistency.MOST_READINGS` readings are looked at, however long the log is. Raises
    :class:`ConfigError` for a trajectory that the log lacks.
    """
    log = at_middle_of_sweep(log, trajectory, config.time_offset)
    seen = examined(log, trajectory)
    if log.n_scans < LEAST_SCANS:
        return None
    values: dict[str, object] = {name: getattr(config, name) for name in _OF_THE_MAP}
    values["range_max"] = min(config.range_max, seen.config.range_max)
    found = check_drift(log, replace(seen, config=seen.config.with_values(values)))
    return found[0] if found else None
