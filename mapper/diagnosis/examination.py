"""All checks, one after another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from mapper.core.errors import ConfigError
from mapper.diagnosis import clock, mounting, readings, timing, walls
from mapper.diagnosis.consistency import Examined, examined
from mapper.diagnosis.finding import Finding
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog

LEAST_SCANS = 10  #: below this there is nothing to compare


@dataclass(frozen=True, slots=True)
class Check:
    """One check; what it would say means nothing where one of ``spoiled_by`` was found."""

    look: Callable[[ScanLog, Examined], list[Finding]]
    spoiled_by: frozenset[str] = frozenset()


_FEW = frozenset({readings.FEW})
_TURNED = _FEW | {"mount.turned"}

#: In the order in which a person should look: what spoils the others comes first.
CHECKS: tuple[Check, ...] = (
    Check(clock.check),
    Check(readings.check),
    Check(mounting.check_turned, _FEW),
    Check(timing.check, _TURNED),
    Check(mounting.check_offset, _TURNED | {"timing.delay"}),
    Check(walls.check_still, _TURNED | {"timing.delay"}),
    Check(walls.check_drift, _TURNED | {"timing.delay"}),
    Check(walls.check_moving, _TURNED | {"timing.delay", "mount.offset", "walls.drift", "poses.still"}),
)


def examine(
    log: ScanLog,
    trajectory: str | None = None,
    progress: Callable[[float], None] | None = None,
    wanted: Callable[[], bool] = lambda: True,
    time_offset: float = 0.0,
) -> list[Finding]:
    """Return what all checks find in a log with one of its trajectories, the surest first within a check.

    Each scan is judged from one pose, in the middle of its sweep where it could be deskewed; ``time_offset`` seconds
    are added to the stamps to find it, as by the mapping parameter of that name. ``progress`` is called with the share
    that is done; ``wanted`` is asked all the while. Raises :class:`ConfigError` for a log too short to judge and for a
    trajectory that it lacks, and :class:`WorkCancelledError` soon after ``wanted`` said False.
    """
    if log.n_scans < LEAST_SCANS:
        raise ConfigError(
            "doctor.short", f"A log of {log.n_scans} scans is too short to judge; {LEAST_SCANS} are enough."
        )
    log = at_middle_of_sweep(log, trajectory, time_offset)
    seen = replace(examined(log, trajectory), time_offset=time_offset, wanted=wanted)
    found: list[Finding] = []
    for done, check in enumerate(CHECKS):
        if progress is not None:
            progress(done / len(CHECKS))
        if not check.spoiled_by & {finding.check for finding in found}:
            new = check.look(log, seen)
            found += new
            for finding in new:
                if finding.check == "mount.offset":  # so that what the mount spoils is not taken for drift
                    seen = replace(seen, config=seen.config.with_values(finding.parameters or {}))
    return found
