"""All checks, in order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mapper.core.errors import ConfigError
from mapper.diagnosis import clock, mounting, readings, sparse, sweep, timing, walls
from mapper.diagnosis.between import check_between
from mapper.diagnosis.consistency import MOST_READINGS, Contradiction, Examined, examined
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.several import of_sensors, share_of
from mapper.sensors.joint_log import by_sensor, each_part
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog

FEWER_READINGS = 20_000  #: readings examined by :func:`causes_of_drift`
#: Findings that cause double walls, and drift itself.
DOUBLING = frozenset(
    {sparse.CHECK, sweep.CHECK, "mount.turned", "timing.delay", "mount.offset", "walls.drift", mounting.CHANGING}
)
LEAST_SCANS = 10  #: minimum for a comparison


@dataclass(frozen=True, slots=True)
class Check:
    """One check: ``names`` are those of its findings; it is skipped if one of ``spoiled_by`` was found.

    For :data:`REMEDIED` findings the remedial parameters are applied before the following checks, so that their effects
    are not reported again under another name.
    """

    look: Callable[[ScanLog, Examined], list[Finding]]
    names: tuple[str, ...]
    spoiled_by: frozenset[str] = frozenset()


#: Findings whose remedy the following checks use.
REMEDIED = frozenset({"readings.max_range", sweep.CHECK, "mount.offset"})


def _delay_or_offset(log: ScanLog, seen: Examined) -> list[Finding]:
    """Decide between a pose delay and a mount offset, which are equivalent for a robot that drives straight.

    If both improve the sharpness of the map, the larger improvement decides.
    """
    findings = [*timing.check(log, seen), *mounting.check_offset(log, seen)]
    return sorted(findings, key=lambda finding: finding.sure, reverse=True)[:1]


_FEW = frozenset({readings.FEW, sparse.CHECK})
_CHANGING = _FEW | {mounting.CHANGING}
_TURNED = _CHANGING | {"mount.turned"}

#: In the order in which a person should look: checks that affect others come first.
CHECKS: tuple[Check, ...] = (
    Check(clock.check, ("clock.backwards", "clock.doubled", "clock.gap", "clock.dropped", "clock.jitter")),
    Check(lambda log, seen: clock.check_unit(log, seen.trajectory), ("clock.unit",)),
    Check(readings.check, (readings.FEW, "readings.max_range", "readings.itself")),
    Check(sparse.check, (sparse.CHECK,), frozenset({readings.FEW})),
    Check(sweep.check_sweep, (sweep.CHECK,), _FEW),
    Check(lambda log, _: timing.check_clock(log), (timing.CLOCK,), _FEW),
    Check(mounting.check_changing, (mounting.CHANGING,), _FEW),
    Check(mounting.check_turned, ("mount.turned",), _CHANGING),
    Check(_delay_or_offset, ("timing.delay", "mount.offset"), _TURNED),
    Check(walls.check_still, ("poses.still",), _TURNED | {"timing.delay"}),
    Check(walls.check_drift, ("walls.drift",), _TURNED | {"timing.delay"}),
    Check(
        walls.check_moving, ("walls.moving",), _TURNED | {"timing.delay", "mount.offset", "walls.drift", "poses.still"}
    ),
)


def examine(
    log: ScanLog,
    trajectory: str | None = None,
    progress: Callable[[float], None] | None = None,
    may_continue: Callable[[], bool] = lambda: True,
    time_offset: float = 0.0,
    compared: Callable[[Contradiction], None] = lambda _: None,
) -> list[Finding]:
    """Return the findings of all checks on a log with one of its trajectories, the most certain first within a check.

    Each scan has one pose, in the middle of its sweep if it could be deskewed; ``time_offset`` seconds are added to the
    stamps to look it up, like the mapping parameter of that name. ``progress`` is called with the fraction done;
    ``may_continue`` is called repeatedly; ``compared`` is called with the measurements of the drift check, if it was
    made. If there are several sensors, each is examined separately and its findings name it
    (:func:`mapper.diagnosis.several.of_sensors`), and the lidars are compared with the first one
    (:func:`mapper.diagnosis.between.check_between`); one with too few scans has the finding ``readings.few``. Raises
    :class:`ConfigError` for a log too short to examine and for a trajectory that it lacks, and
    :class:`WorkCancelledError` soon after ``may_continue`` returned False.
    """
    sensors = by_sensor(log)
    if len(sensors) == 1:
        return _examine_one(log, trajectory, progress, may_continue, time_offset, compared)
    longest = max((sensor for sensor, _ in sensors), key=lambda sensor: sensor.n_scans)
    if longest.n_scans < LEAST_SCANS:
        raise _too_short(longest)
    findings = []
    for number, (sensor, _) in enumerate(sensors):
        if sensor.n_scans < LEAST_SCANS:
            findings.append([readings.few_scans(sensor.n_scans)])
            continue
        share = share_of(progress, number, len(sensors) + 1)
        findings.append(_examine_one(sensor, trajectory, share, may_continue, time_offset, compared))
    if progress is not None:
        progress(len(sensors) / (len(sensors) + 1))
    between = check_between([sensor for sensor, _ in sensors], trajectory, findings, may_continue, time_offset)
    return [*of_sensors(sensors, findings), *between]


def causes_of_drift(log: ScanLog, trajectory: str | None, names: frozenset[str] = DOUBLING) -> list[Finding]:
    """Return the findings of a one-sensor log that cause double walls, and drift, if it remains with the remedies.

    Only the checks of ``names`` are made, on a part of the readings, to keep the cost low.
    """
    checks = [check for check in CHECKS if set(check.names) & names]
    return _examine_one(log, trajectory, None, lambda: True, 0.0, lambda _: None, checks, FEWER_READINGS)


def _too_short(log: ScanLog) -> ConfigError:
    return ConfigError("doctor.short", f"A log of {log.n_scans} scans is too short to judge; {LEAST_SCANS} are enough.")


def _examine_one(
    log: ScanLog,
    trajectory: str | None,
    progress: Callable[[float], None] | None,
    may_continue: Callable[[], bool],
    time_offset: float,
    compared: Callable[[Contradiction], None],
    checks: Sequence[Check] = CHECKS,
    most: int = MOST_READINGS,
) -> list[Finding]:
    """Return :func:`examine` for a one-sensor log with some of the checks, which examine ``most`` readings."""
    if log.n_scans < LEAST_SCANS:
        raise _too_short(log)
    stated, log = log, at_middle_of_sweep(log, trajectory, time_offset)
    seen = replace(
        examined(log, trajectory, most), time_offset=time_offset, may_continue=may_continue, compared=compared
    )
    findings: list[Finding] = []
    for done, check in enumerate(checks):
        if progress is not None:
            progress(done / len(checks))
        if check.spoiled_by & {finding.check for finding in findings}:
            continue
        new = check.look(stated if check.names in ((sparse.CHECK,), (sweep.CHECK,)) else log, seen)
        findings += new
        for finding in new:
            if finding.check not in REMEDIED or finding.parameters is None:
                continue
            if finding.check == sweep.CHECK:
                at_once = each_part(stated, lambda part: replace(part, time_increment=0.0))
                log = at_middle_of_sweep(at_once, trajectory, time_offset)
                seen = replace(seen, log=examined(log, trajectory, most).log)
            else:
                seen = replace(seen, config=seen.config.with_values(remedy_of(finding, seen)))
    return findings


def remedy_of(finding: Finding, seen: Examined) -> dict[str, object]:
    """Return the parameters of a finding as the examination uses them, with the range limited to that examined."""
    values = dict(finding.parameters or {})
    if "range_max" in values:
        values["range_max"] = min(values["range_max"], seen.config.range_max)
    return values
