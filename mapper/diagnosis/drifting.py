"""Check of one trajectory for drift and its causes; mapping commands report the first of them."""

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
    """Return the drift finding of ``trajectory`` (None: the log's default), or None if there is none.

    ``config`` has the correction of the mount, the time offset and the maximum range, metres. At most
    :data:`mapper.diagnosis.consistency.MOST_READINGS` readings are examined, regardless of the log's length. Raises
    :class:`ConfigError` for a trajectory that the log lacks.
    """
    whole, seen = examined_as_mapped(log, trajectory, config)
    if log.n_scans < LEAST_SCANS:
        return None
    findings = check_drift(whole, seen)
    return findings[0] if findings else None


def first_cause(log: ScanLog, trajectory: str | None, config: MappingConfig) -> Finding | None:
    """Return the first cause, or drift, that degrades the map of a log with ``config``, as far as it is cheap to find.

    Causes other than drift and a wrong sweep are only searched if walls are double, the mount is unknown or beams are
    deskewed; then a few more maps of some of the readings are made. Raises the errors of :func:`drift_finding`.
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
    # A wrong sweep or clock found when the log was read is mapped correctly.
    corrected = each_part(as_mapped(log, config), lambda part: replace(part, wrong_sweep="", wrong_clock=""))
    if config.deskew == "off":
        corrected = each_part(corrected, lambda part: replace(part, time_increment=0.0))
    if drift is None and not log.trajectory(trajectory).is_placeholder:
        # The drift check ignores the motion within a scan, so a wrong sweep is not drift.
        still = check_still(*examined_as_mapped(log, trajectory, config))
        # A mount with a large error widens all walls so much that scans a moment apart also contradict each other. The
        # same holds for a sweep that is stamped at its end.
        names = {sweep.CHECK} | ({"mount.offset"} if log.mount_assumed else set())
        names |= {"timing.delay"} if corrected.can_deskew(trajectory) else set()
        causes = _sure(still or causes_of_drift(corrected, trajectory, frozenset(names)))
        return causes[0] if causes else None
    if drift is None:
        return None
    causes = _sure(causes_of_drift(corrected, trajectory))
    return causes[0] if causes and all(cause.check != drift.check for cause in causes) else drift


def _sure(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings that are more than possible, which are reported with a map as facts."""
    return [finding for finding in findings if not finding.possible]
