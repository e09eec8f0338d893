"""Merging of two maps of one place: log-odds are added and the prior is counted once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import wrap_angle
from mapper.grid.occupancy_grid import GridGeometry, OccupancyGrid

LATTICE_TOLERANCE = 1e-3  #: in cells: largest offset at which two lattices count as the same


def merged(a: OccupancyGrid, b: OccupancyGrid) -> OccupancyGrid:
    """Return the map with the evidence of both: ℓ = ℓ_a + ℓ_b − ℓ₀ where both have cells.

    Evidence from different scans is assumed to be independent given the map, so its log-odds add (Thrun, Burgard & Fox,
    Probabilistic Robotics, sections 4.2 and 9.2). Both maps started from ℓ₀, so one ℓ₀ is subtracted. With the clamp
    off, merged partial maps of a log equal the map built at once, up to the rounding of float32 additions in another
    order. With the clamp they may differ: a cell at its limit in one part has lost the evidence beyond it, and the sum
    may exceed the limits, which no single map does.

    The result covers both grids on the lattice of ``a``. A prior map of only one grid is assumed to apply to both.
    Raises :class:`ConfigError` if resolution, yaw or prior differ, the cells do not coincide, or a grid is not a sum of
    log-odds (it has cell statistics), and :class:`mapper.core.errors.LimitError` if the result is too large.
    """
    if a.log_odds_prior != b.log_odds_prior:
        raise ConfigError("merge.prior", f"The priors differ: {a.log_odds_prior:g} and {b.log_odds_prior:g}.")
    if a.cell_statistics is not None or b.cell_statistics is not None:
        raise ConfigError("merge.model", "Only maps of log-odds can be merged; one of these has another model.")
    whole, places = on_one_lattice(a, b)
    parts = list(zip((a, b), places, strict=True))
    out = OccupancyGrid(whole, a.log_odds_prior, _prior_map(whole.shape, parts))
    for grid, part in parts:
        out.log_odds[part] += grid.log_odds - grid.prior()
        out.observed[part] |= grid.observed
    return out


Part = tuple[slice, slice]


def on_one_lattice(a: OccupancyGrid, b: OccupancyGrid) -> tuple[GridGeometry, tuple[Part, Part]]:
    """Return the geometry that contains both grids, on the lattice of ``a``, and the part of it that each covers.

    Raises :class:`ConfigError` if the cells do not coincide, and :class:`mapper.core.errors.LimitError` if the result
    is too large.
    """
    row, col = _offset(a.geometry, b.geometry)
    rows, cols = b.geometry.shape
    top, left = min(0, row), min(0, col)
    bottom, right = max(a.geometry.rows, row + rows), max(a.geometry.cols, col + cols)
    corner = a.geometry.cell_to_world((top - 0.5, left - 0.5))
    origin = (float(corner[0]), float(corner[1]), a.geometry.origin[2])
    whole = GridGeometry(a.geometry.resolution, bottom - top, right - left, origin, a.geometry.limits)
    place_a = np.s_[-top : -top + a.geometry.rows, -left : -left + a.geometry.cols]
    place_b = np.s_[row - top : row - top + rows, col - left : col - left + cols]
    return whole, (place_a, place_b)


def _prior_map(shape: tuple[int, int], parts: list[tuple[OccupancyGrid, Part]]) -> NDArray[np.float32] | None:
    """Return the prior map that both grids started from, or None if neither has one."""
    if all(grid.prior_map is None for grid, _ in parts):
        return None
    out = np.full(shape, np.nan, dtype=np.float32)
    for grid, part in parts:
        prior = np.full(grid.geometry.shape, np.nan, np.float32) if grid.prior_map is None else grid.prior_map
        known = ~np.isnan(out[part])
        if np.any(known & ~np.isnan(prior) & (out[part] != prior)):
            raise ConfigError("merge.prior", "The prior maps differ where both maps have cells.")
        out[part] = np.where(known, out[part], prior)
    return out


def _offset(a: GridGeometry, b: GridGeometry) -> tuple[int, int]:
    """Return the row and the column of ``a`` at which cell (0, 0) of ``b`` lies."""
    turn = abs(float(wrap_angle(a.origin[2] - b.origin[2])))
    if (
        abs(a.resolution - b.resolution) * max(b.shape) > LATTICE_TOLERANCE * a.resolution
        or turn * max(b.shape) > LATTICE_TOLERANCE
    ):
        raise ConfigError(
            "merge.geometry",
            f"Grids of {a.resolution:g} m at yaw {a.origin[2]:g} and of {b.resolution:g} m at yaw {b.origin[2]:g} "
            "have no cells in common.",
        )
    exact = a.to_lattice(b.origin[:2])[::-1]
    whole = np.round(exact)
    if np.abs(exact - whole).max() > LATTICE_TOLERANCE:
        raise ConfigError(
            "merge.geometry", f"The grids lie {exact[0]:g} rows and {exact[1]:g} columns apart, not a whole number."
        )
    return int(whole[0]), int(whole[1])
