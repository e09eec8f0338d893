"""Model of a map for localization, computed once: likelihood field, occupied and free cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.grid import FREE, GridGeometry, OccupancyGrid
from mapper.localization.kernels.types import OccupiedCells
from mapper.localization.likelihood_field import LikelihoodField, likelihood_field, occupied_cells
from mapper.localization.parameters import LocalizationConfig


@dataclass(frozen=True, slots=True)
class MapModel:
    """One map for one set of parameters; can be shared between filters.

    ``free_cells`` (m,) int64 are row · columns + column of the cells in which a robot may be.
    """

    geometry: GridGeometry
    field: LikelihoodField
    cells: OccupiedCells
    free_cells: NDArray[np.int64]


def check_pose(geometry: GridGeometry, pose: ArrayLike) -> NDArray[np.float64]:
    """Return a pose (3,) as an array. Raises :class:`ConfigError` unless it is finite and in the map."""
    checked = np.asarray(pose, dtype=np.float64)
    if checked.shape != (3,) or not np.isfinite(checked).all():
        raise ConfigError(
            "localization.pose", f"A pose must be three finite numbers, x, y and yaw, not {checked.tolist()!r:.80}."
        )
    if not geometry.contains(geometry.world_to_cell(checked[:2])):
        raise ConfigError(
            "localization.pose_outside",
            f"The pose ({checked[0]:g}, {checked[1]:g}) m is outside the map, which {geometry.span_text}.",
        )
    return checked


def map_model(grid: OccupancyGrid, config: LocalizationConfig, range_max: float) -> MapModel:
    """Return the model of a map for localization; ``range_max``, metres, is the maximum range used.

    Raises :class:`ConfigError` for a map without free or without occupied cells.
    """
    free = np.flatnonzero(grid.classify().ravel() == FREE)
    if not len(free):
        raise ConfigError("localization.no_free_cells", "The map has no free cells, so it has no place for the robot.")
    field = likelihood_field(grid, config, range_max)
    cells = OccupiedCells(occupied_cells(grid), grid.geometry.frame)
    return MapModel(grid.geometry, field, cells, free.astype(np.int64))
