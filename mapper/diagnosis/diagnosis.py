"""Findings on a log and events of its recording, combined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mapper.diagnosis.events import DISPLACED, Event, find_events
from mapper.diagnosis.examination import LEAST_SCANS, examine
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.mounting import CHANGING
from mapper.mapping.parameters import MappingConfig, as_mapped
from mapper.sensors.joint_log import by_sensor, each_part
from mapper.sensors.scan import ScanLog

EXAMINED = 0.6  #: fraction of the work for the findings
DRIFT, DELAY = "walls.drift", "timing.delay"
MOST_NAMED = 3  #: events that a finding mentions


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """The findings on a log with one of its trajectories, causes first, and the events of its recording in time
    order.
    """

    findings: tuple[Finding, ...]
    events: tuple[Event, ...]


def diagnose(
    log: ScanLog,
    trajectory: str | None = None,
    progress: Callable[[float], None] | None = None,
    may_continue: Callable[[], bool] = lambda: True,
    time_offset: float = 0.0,
) -> Diagnosis:
    """Return :func:`examine` of a log, and its events (:func:`mapper.diagnosis.events.find_events`).

    If the wheels missed a motion, drift of their poses is a consequence, and its finding mentions it. Raises the errors
    of both.
    """

    def part(begin: float, end: float) -> Callable[[float], None] | None:
        return None if progress is None else lambda share: progress(begin + (end - begin) * share)

    findings = examine(log, trajectory, part(0.0, EXAMINED), may_continue, time_offset)
    events = find_events(_remedied(log, findings), may_continue, part(EXAMINED, 1.0))
    # With different clocks wheels seem to miss each turn, and with a changing mount each change.
    if any(finding.check in (DELAY, CHANGING) for finding in findings):
        events = [event for event in events if event.kind not in DISPLACED]
    along = trajectory or log.default_trajectory
    is_own = (log.trajectory(along).frame_id or "").strip("/").endswith("odom")
    if is_own:
        findings = [_with_cause(finding, events) for finding in findings]
    return Diagnosis(tuple(findings), tuple(events))


def events_of(log: ScanLog, trajectory: str | None = None) -> tuple[Event, ...]:
    """Return the events of :func:`diagnose`; none for a log that is too short to examine."""
    is_long = any(sensor.n_scans >= LEAST_SCANS for sensor, _ in by_sensor(log))
    return diagnose(log, trajectory).events if is_long else ()


def _remedied(log: ScanLog, findings: Sequence[Finding]) -> ScanLog:
    """Return the log with mount, clocks and maximum range corrected as in the findings, so that they cause no events.

    With a wrong mount the robot seems to move where it turns, and a no return written as a range is a wall that moves
    with it.
    """
    if len(by_sensor(log)) > 1:
        return log
    config = MappingConfig()
    for finding in findings:
        config = config.with_values(finding.parameters or {})
    limits = [
        finding.parameters["range_max"]
        for finding in findings
        if finding.parameters and "range_max" in finding.parameters
    ]

    def remedied(part: ScanLog) -> ScanLog:
        increment = 0.0 if config.deskew == "off" else part.time_increment
        return replace(part, range_max=min([part.range_max, *limits]), time_increment=increment)

    return each_part(as_mapped(log, config), remedied)


def _with_cause(finding: Finding, events: Sequence[Event]) -> Finding:
    """Add the events that displaced the robot, as the cause, to a drift finding; return others unchanged."""
    moved = [event for event in events if event.kind in DISPLACED]
    if finding.check != DRIFT or not moved:
        return finding
    at = [event.time for event in moved[:MOST_NAMED]]
    times = f"{', '.join(at[:-1])} and {at[-1]}" if len(at) > 1 else at[0]
    more = f" and {len(moved) - MOST_NAMED} times later" if len(moved) > MOST_NAMED else ""
    return replace(
        finding,
        sentence=f"{finding.sentence} The wheels did not measure what happened at {times}{more}: poses are off "
        "from there on.",
        scans=(moved[0].scan, *finding.scans),
    )
