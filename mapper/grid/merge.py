"""Two maps of one place as one: log-odds added, the prior counted once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import wrap_angle
from mapper.grid.occupancy_grid import GridGeometry, OccupancyGrid

LATTICE_TOLERANCE = 1e-3  #: of a cell: how far two lattices may lie apart and still be the same


def merged(a: OccupancyGrid, b: OccupancyGrid) -> OccupancyGrid:
    """Return the map that holds the evidence of both: ℓ = ℓ_a + ℓ_b − ℓ₀ where both have cells.

    Evidence from different scans is taken to be independent given the map, so its log-odds add (Thrun, Burgard & Fox,
    Probabilistic Robotics, sections 4.2 and 9.2); each of the two started from ℓ₀, so one ℓ₀ is taken away. Partial
    maps of a log, merged, equal the map made in one go when the clamp is off, up to the rounding of float32 additions
    in another order. With the clamp they may not: a cell that one part held at its limit has lost the evidence
    beyond it, and the sum may be outside the limits, which no single map exceeds.

    The result covers both grids; its lattice is that of ``a``; a prior map that only one of them started from is taken
    to hold for both. Raises :class:`ConfigError` where resolution, yaw or prior differ, the cells of one do not
    coincide with the other's, or a grid is no sum of log-odds (it has cell statistics), and
    :class:`mapper.core.errors.LimitError` where the two together are too large.
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
    """Return the geometry that holds both grids, on the lattice of ``a``, and which part of it each one covers.

    Raises :class:`ConfigError` where the cells of one do not coincide with the other's, and
    :class:`mapper.core.errors.LimitError` where the two together are too large.
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
    """Return the prior map that both grids started from, None where neither did."""
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
