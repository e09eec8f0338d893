"""Figures for the quality of a map of one log along one of its trajectories."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.diagnosis.consistency import contradiction, examined_as_mapped, unthinned
from mapper.diagnosis.verdict import map_of
from mapper.grid import OccupancyGrid
from mapper.grid.compare import wall_contrast
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import by_sensor
from mapper.sensors.scan import ScanLog


@dataclass(frozen=True, slots=True)
class MapFigures:
    """Agreement on wall positions between parts of a log recorded at different times.

    ``drift_m`` is :meth:`mapper.diagnosis.consistency.Contradiction.offset`, metres; ``contradicted`` is the fraction,
    0 to 1, of readings that end where beams of another time passed freely. Both are None if too few readings can be
    compared, and for sonars; for several sensors they are the maxima. ``sharpness`` is
    :func:`mapper.grid.compare.wall_contrast` of the map, 0 to 1.
    """

    drift_m: float | None
    contradicted: float | None
    sharpness: float


def map_figures(
    log: ScanLog, trajectory: str | None, config: MappingConfig, grid: OccupancyGrid | None = None
) -> MapFigures:
    """Return the figures of the map of a log along a trajectory with ``config``, including its mount and time offset.

    ``grid`` is that map if it has already been made. Raises :class:`ConfigError` for a trajectory that the log lacks
    and :class:`LimitError` for a map that is too large.
    """
    drifts, shares = [], []
    for sensor, _ in by_sensor(log):
        if sensor.beam_width > 0.0 or not sensor.n_scans:
            continue
        whole, seen = examined_as_mapped(sensor, trajectory, config)
        compared = contradiction(unthinned(whole, seen), seen)
        drift = compared.offset()
        if drift is not None:
            drifts.append(drift)
            shares.append(compared.far)
    sharpness = wall_contrast(map_of(log, trajectory, config) if grid is None else grid)
    return MapFigures(max(drifts, default=None), max(shares, default=None), sharpness)
