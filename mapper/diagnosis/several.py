"""Conversion of findings on the sensors of one log to findings on the whole log."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from mapper.core.array_types import Int64Array
from mapper.diagnosis.finding import Finding
from mapper.sensors.scan import ScanLog

#: Advice for a value that only some of the sensors need.
BY_ITSELF = "The parameters of a map are those of all its sensors: map this one by itself with such a value."


def of_sensors(sensors: Sequence[tuple[ScanLog, Int64Array]], of_sensors: Sequence[Sequence[Finding]]) -> list[Finding]:
    """Return the findings on each of a log's sensors as findings on the log.

    ``sensors`` are those of :func:`mapper.sensors.joint_log.by_sensor`, in the order of ``of_sensors``. Each finding
    names its sensor, and its scans are indices into ``log``. The mapping parameters apply to all sensors, so a finding
    keeps its own only if every sensor has a finding of the same check with parameters.
    """
    common = set.intersection(
        *({finding.check for finding in findings if finding.parameters} for findings in of_sensors)
    )
    joint = []
    for (sensor, numbers), findings in zip(sensors, of_sensors, strict=True):
        for finding in findings:
            scans = tuple(int(numbers[scan]) for scan in finding.scans)
            own = replace(finding, sensor=sensor.topic, scans=scans)
            if own.parameters and own.check not in common:
                own = replace(own, parameters=None, advice=f"{own.advice} {BY_ITSELF}")
            joint.append(own)
    return joint


def share_of(progress: Callable[[float], None] | None, number: int, of: int) -> Callable[[float], None] | None:
    """Return a function that reports the progress of part ``number`` of ``of`` equal ones to ``progress``."""
    return None if progress is None else lambda share: progress((number + share) / of)
