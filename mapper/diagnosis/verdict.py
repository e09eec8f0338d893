"""Check of a log against limits, for automatic tests of a robot's recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from typing import Any

from mapper.core.errors import ConfigError
from mapper.diagnosis import between
from mapper.diagnosis.consistency import LEAST_EVIDENCE, WITHIN, Contradiction
from mapper.diagnosis.examination import CHECKS, examine
from mapper.diagnosis.finding import POSSIBLE, Finding
from mapper.diagnosis.several import of_sensors, share_of
from mapper.grid import OccupancyGrid
from mapper.grid.compare import wall_contrast
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig, recorded_defaults
from mapper.sensors.corrections import corrected_log
from mapper.sensors.joint_log import by_sensor
from mapper.sensors.scan import ScanLog

#: The names of all findings.
FINDINGS = (*(name for check in CHECKS for name in check.names), between.CHECK)
ALL = "all"
DRIFT = "walls.drift"
DRIFT_PLACES, SHARPNESS_PLACES = 2, 3  #: decimals in messages, and in the comparison with the limits
ROUNDING = 1e-9  #: a value equal to its limit passes


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits on a log; those that are None or empty are not checked.

    ``max_drift`` is in metres, for :meth:`mapper.diagnosis.consistency.Contradiction.offset`; ``min_sharpness`` is 0 to
    1, for :func:`mapper.grid.compare.wall_contrast`; ``no_findings`` are names of findings that must not occur.
    Findings that are only possible count if ``possible``; so do those that prevented another check.
    """

    max_drift: float | None = None
    min_sharpness: float | None = None
    no_findings: frozenset[str] = frozenset()
    possible: bool = False


@dataclass(frozen=True, slots=True)
class Reason:
    """One exceeded limit.

    ``check`` is ``drift``, ``sharpness`` or the name of a finding. ``measured`` is in the unit of the limit: metres, 0
    to 1, or the confidence of the finding, 0 to 1; None if it could not be measured. ``sentence`` states both.
    ``sensor`` is the topic of the sensor concerned if several were judged, else empty.
    """

    check: str
    measured: float | None
    limit: float
    sentence: str
    sensor: str = ""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Result of the check of a log: ``reasons`` why it fails, empty if it passes.

    ``drift`` (metres, the maximum over several sensors) and ``sharpness`` (0 to 1) are None if not requested or not
    measurable. ``findings`` are all findings of the doctor, None if neither drift nor findings were requested.
    """

    reasons: tuple[Reason, ...]
    drift: float | None
    sharpness: float | None
    findings: tuple[Finding, ...] | None

    @property
    def passed(self) -> bool:
        """Whether all limits are met."""
        return not self.reasons

    def public(self) -> dict[str, Any]:
        """Return the fields and ``passed``, for JSON."""
        return {
            "passed": self.passed,
            "reasons": [asdict(reason) | {"measured": _rounded(reason.measured)} for reason in self.reasons],
            "drift_m": _rounded(self.drift),
            "sharpness": _rounded(self.sharpness),
            "findings": None if self.findings is None else [finding.public() for finding in self.findings],
        }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def named_findings(names: Iterable[str]) -> frozenset[str]:
    """Return the names of findings selected by ``names``: each a full name, its part before the dot, or ``all``.

    Raises :class:`ConfigError`, listing the valid names, for any other name.
    """
    named: set[str] = set()
    for name in names:
        meant = [finding for finding in FINDINGS if name in (ALL, finding, finding.partition(".")[0])]
        if not meant:
            raise ConfigError(
                "check.finding", f"There is no finding {name!r:.40}; there are {ALL}, {', '.join(FINDINGS)}."
            )
        named.update(meant)
    return frozenset(named)


def judge(
    log: ScanLog,
    limits: Limits,
    trajectory: str | None = None,
    config: MappingConfig | None = None,
    progress: Callable[[float], None] | None = None,
) -> Verdict:
    """Check whether ``log`` with one of its trajectories (None: its first) meets ``limits``.

    ``config`` has a correction of the mount and of the clock; the rest of it is not used, because sharpness is judged
    in the map with the sensor's default parameters. For several sensors each is judged separately, and the sharpness is
    that of their common map. A value that cannot be measured fails. ``progress`` is called with the fraction done.
    Raises :class:`ConfigError` for a trajectory that the log lacks, for a mount correction of several sensors and, if
    drift or findings are requested, for a log too short to examine; :class:`LimitError` for a map that is too large.
    """
    if len(by_sensor(log)) > 1:
        return _judge_sensors(log, limits, trajectory, config, progress)
    time_offset = 0.0 if config is None else config.time_offset
    if config is not None:
        log = corrected_log(log, config.mount, turned_over=config.mount_upside_down)
    findings: tuple[Finding, ...] | None = None
    compared: list[Contradiction] = []
    if limits.max_drift is not None or limits.no_findings:
        findings = tuple(examine(log, trajectory, progress, time_offset=time_offset, compared=compared.append))
    drift = compared[0].offset() if compared and limits.max_drift is not None else None
    reasons = []
    if limits.max_drift is not None:
        why = _why_unmeasured(log, trajectory, findings or ()) if drift is None else ""
        reasons += _drift_reasons(drift, limits.max_drift, why)
    sharpness, more = _sharpness(log, limits, trajectory, time_offset)
    reasons += more
    reasons += _finding_reasons(findings or (), limits)
    return Verdict(tuple(reasons), drift, sharpness, findings)


def _judge_sensors(
    log: ScanLog,
    limits: Limits,
    trajectory: str | None,
    config: MappingConfig | None,
    progress: Callable[[float], None] | None,
) -> Verdict:
    config = config or MappingConfig()
    if config.mount_upside_down or any(config.mount):
        raise ConfigError("check.mount", "A correction of the mount is for one sensor; judge it by itself.")
    alone = replace(limits, min_sharpness=None)
    verdicts = []
    sensors = by_sensor(log)
    for number, (sensor, _) in enumerate(sensors):
        share = share_of(progress, number, len(sensors))
        try:
            verdicts.append(judge(sensor, alone, trajectory, config, share))
        except ConfigError as error:
            raise ConfigError(error.code, f"{sensor.topic}: {error.message}") from error
    reasons = [
        replace(reason, sensor=sensor.topic)
        for (sensor, _), verdict in zip(sensors, verdicts, strict=True)
        for reason in verdict.reasons
    ]
    sharpness, more = _sharpness(log, limits, trajectory, config.time_offset)
    known = [verdict.findings for verdict in verdicts if verdict.findings is not None]
    findings: tuple[Finding, ...] | None = None
    if known:
        logs = [sensor for sensor, _ in sensors]
        both = between.check_between(logs, trajectory, known, lambda: True, config.time_offset)
        findings = (*of_sensors(sensors, known), *both)
        more += [
            replace(reason, sensor=finding.sensor)
            for finding in both
            for reason in _finding_reasons((finding,), limits)
        ]
    drifts = [verdict.drift for verdict in verdicts if verdict.drift is not None]
    return Verdict((*reasons, *more), max(drifts, default=None), sharpness, findings)


def _sharpness(
    log: ScanLog, limits: Limits, trajectory: str | None, time_offset: float
) -> tuple[float | None, list[Reason]]:
    """Return the sharpness of a log's map, None if not requested, and the reason for failure."""
    if limits.min_sharpness is None:
        return None, []
    sharpness = sharpness_of(log, trajectory, time_offset)
    if round(sharpness, SHARPNESS_PLACES) >= limits.min_sharpness - ROUNDING:
        return sharpness, []
    sentence = f"The sharpness of the walls is {sharpness:.3f}; the limit is {limits.min_sharpness:.3f}."
    return sharpness, [Reason("sharpness", sharpness, limits.min_sharpness, sentence)]


def map_of(log: ScanLog, trajectory: str | None, config: MappingConfig | None = None) -> OccupancyGrid:
    """Return the map of a log with ``config``; None means the default parameters of its sensor."""
    if config is None:
        config = MappingConfig().with_values(recorded_defaults(log.beam_width, {}))
    grid = grid_for(log, config, trajectory)
    integrate_log(grid, log, config, trajectory)
    return grid


def sharpness_of(log: ScanLog, trajectory: str | None, time_offset: float = 0.0) -> float:
    """Return the sharpness, 0 to 1, of the walls in the map of a log with its sensor's default parameters."""
    config = MappingConfig().with_values(recorded_defaults(log.beam_width, {"time_offset": time_offset}))
    return wall_contrast(map_of(log, trajectory, config))


def _drift_reasons(drift: float | None, limit: float, why: str) -> list[Reason]:
    if drift is None:
        return [Reason("drift", None, limit, f"Drift could not be measured: {why}; the limit is {limit:.2f} m.")]
    if round(drift, DRIFT_PLACES) <= limit + ROUNDING:
        return []
    sentence = (
        f"Only {100 * WITHIN:.0f} % of the readings end within {drift:.2f} m of the walls that were seen at another "
        f"time; the limit is {limit:.2f} m."
    )
    return [Reason("drift", drift, limit, sentence)]


def _why_unmeasured(log: ScanLog, trajectory: str | None, findings: Iterable[Finding]) -> str:
    if spoilers := _spoilers(DRIFT, findings):
        return f"{' and '.join(spoilers)} was found"
    if log.beam_width > 0.0:
        return "a sonar’s readings are too wide for it"
    poses = log.trajectory(trajectory).poses
    if (poses == poses[:1]).all():
        return "the poses stay in one place"
    return f"fewer than {LEAST_EVIDENCE:.0f} readings are of places that the robot saw earlier"


def _spoilers(name: str, findings: Iterable[Finding]) -> list[str]:
    """Return the findings because of which the check of ``name`` was skipped."""
    spoiled_by = next((check.spoiled_by for check in CHECKS if name in check.names), frozenset[str]())
    return [finding.check for finding in findings if finding.check in spoiled_by]


def _finding_reasons(findings: tuple[Finding, ...], limits: Limits) -> list[Reason]:
    least = 0.0 if limits.possible else POSSIBLE
    counted = [finding for finding in findings if finding.check in limits.no_findings and finding.stated_sure >= least]
    reasons = [
        Reason(
            finding.check,
            finding.sure,
            least,
            f"{finding.sentence} ({100 * finding.sure:.0f} % sure; counted from {100 * least:.0f} %)",
        )
        for finding in counted
    ]
    failed = {finding.check for finding in counted}
    for name in FINDINGS:
        sure = [finding for finding in findings if finding.stated_sure >= least]
        spoilers = _spoilers(name, sure) if name in limits.no_findings else []
        # A finding that is already a reason is not listed again for the check it prevented.
        if spoilers and not failed.intersection(spoilers):
            reasons.append(Reason(name, None, least, f"It could not be examined: {' and '.join(spoilers)} was found."))
    return reasons
