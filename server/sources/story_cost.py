"""Estimate of the computing time for replaying a story."""

from __future__ import annotations

from typing import Any

from mapper.core.errors import LimitError, MapperError
from mapper.simulation import SensorConfig
from mapper.simulation.kernels.driving import STEP
from mapper.simulation.sonar import rays_of_cone

# Processor time in seconds, measured in the largest world on one core of a small server.
STEP_S = 1.2e-4  #: one step of the simulation
SCAN_S = 6e-4  #: one scan, whatever its readings
BEAM_S = 1.1e-6  #: one beam of a lidar
RAY_S = 2.6e-6  #: one ray of a sonar's cone, with its part of the map
ACTION_S = 8e-3  #: one action after which the robot plans its path again
SOLID_S = 1e-4  #: one wall or box of an edit
_PLANNED_ANEW = ("teleport", "edit", "auto")


def story_seconds(story: dict[str, Any]) -> float:
    """Return the estimated processor time, in seconds, of :func:`server.sources.story.replayed`.

    Invalid values are ignored: they are refused when the story is replayed.
    """
    steps = max(0, story.get("steps") or 0)
    sensor = _with_values(SensorConfig(), story.get("sensor"))
    total, at = STEP_S * steps, 0
    for step, command in story.get("journal") or ():
        until = min(max(step, at), steps)
        total += _scans_s(sensor, until - at)
        at = until
        if command.get("type") in _PLANNED_ANEW:
            total += ACTION_S
        if command.get("type") == "edit":
            added = command.get("added")
            total += SOLID_S * (len(added) if isinstance(added, list) else 0)
        if command.get("type") == "sensor":
            sensor = _with_values(sensor, command.get("values"))
    return total + _scans_s(sensor, steps - at)


def check_story(story: dict[str, Any], max_s: float) -> float:
    """Return :func:`story_seconds`. Raises :class:`LimitError` if that is more than ``max_s``."""
    seconds = story_seconds(story)
    if seconds > max_s:
        raise LimitError(
            "story.costly",
            f"Replaying this world would take about {seconds:.0f} s of computing, more than the {max_s:g} s that this "
            "service allows (setting GRIDBLOOM_MAX_STORY_S).",
        )
    return seconds


def _with_values(sensor: SensorConfig, values: object) -> SensorConfig:
    try:
        return sensor.with_values(values) if isinstance(values, dict) else sensor
    except MapperError:
        return sensor


def _scans_s(sensor: SensorConfig, steps: int) -> float:
    if sensor.kind == "sonar_ring":
        readings_s = RAY_S * sensor.n_sonars * len(rays_of_cone(sensor.beam_width))
    else:
        readings_s = BEAM_S * sensor.n_beams
    return steps * STEP * sensor.scan_rate * (SCAN_S + readings_s)
