"""Check one trajectory for drift and its causes; commands that make a map report the first of them with it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from mapper.diagnosis import sweep
from mapper.diagnosis.consistency import examined_as_mapped
from mapper.diagnosis.examination import LEAST_SCANS, causes_of_drift
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.readings import max_range_finding
from mapper.diagnosis.walls import check_drift, check_still
from mapper.mapping.parameters import MappingConfig, as_mapped
from mapper.sensors.joint_log import by_sensor, each_part
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
    findings = check_drift(whole, seen)
    return findings[0] if findings else None


def first_cause(log: ScanLog, trajectory: str | None, config: MappingConfig) -> Finding | None:
    """Return what makes the map of a log with ``config`` bad, as far as it is known cheaply: its first cause, or drift.

    What is neither drift nor a wrong sweep is looked for only where walls are double, the mount is not known or beams
    are deskewed; then a few more maps of some of the readings are made. Raises as :func:`drift_finding`.
    """
    if log.n_scans < LEAST_SCANS:
        return None
    is_alone = len(by_sensor(log)) == 1
    if is_alone:
        for finding in max_range_finding(log):
            if (finding.parameters or {}).get("range_max", 0.0) < config.range_max:
                return finding
    drift = drift_finding(log, trajectory, config)
    if not is_alone:
        return drift
    # A wrong sweep or clock that was found when the log was read is mapped rightly.
    corrected = each_part(as_mapped(log, config), lambda part: replace(part, wrong_sweep="", wrong_clock=""))
    if config.deskew == "off":
        corrected = each_part(corrected, lambda part: replace(part, time_increment=0.0))
    if drift is None and not log.trajectory(trajectory).is_placeholder:
        # Drift is looked for without the motion within a scan, so a wrong sweep is none.
        still = check_still(*examined_as_mapped(log, trajectory, config))
        # A mount that is far off draws all walls so wide that scans a moment apart contradict each other as well. So
        # does a sweep that is stamped at its end.
        names = {sweep.CHECK} | ({"mount.offset"} if log.mount_assumed else set())
        names |= {"timing.delay"} if corrected.can_deskew(trajectory) else set()
        causes = _sure(still or causes_of_drift(corrected, trajectory, frozenset(names)))
        return causes[0] if causes else None
    if drift is None:
        return None
    causes = _sure(causes_of_drift(corrected, trajectory))
    return causes[0] if causes and all(cause.check != drift.check for cause in causes) else drift


def _sure(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings that are more than possible: a map is reported with one as a fact."""
    return [finding for finding in findings if not finding.possible]
