"""Cell-by-cell comparison of two maps of one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.grid.kernels.count_cells import count_cells, sum_edges
from mapper.grid.merge import Part, on_one_lattice
from mapper.grid.occupancy_grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD, GridGeometry, OccupancyGrid, log_odds

STATES = ("free", "occupied", "unknown")  #: in the order of :attr:`Comparison.states`


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences of ``b`` from ``a`` over the cells of the smallest lattice that contains both.

    ``states`` (3, 3) int64 counts the cells by (state in a, state in b), in the order of :data:`STATES`; its sum is the
    number of cells, and cells that neither map observed are (unknown, unknown). ``only`` counts the cells observed only
    in a and only in b, ``both`` those observed in both. ``entropy_bits`` is each map's entropy summed over the cells
    that either has observed; ``contrast`` is each map's :func:`wall_contrast`. ``mean_difference`` and
    ``max_difference`` are those of |ℓ_b − ℓ_a| over the cells observed in both, 0 where there are none; ``max_at_xy``
    is the centre of the cell with the maximum, in map metres.
    """

    geometry: GridGeometry
    states: NDArray[np.int64]
    only: tuple[int, int]
    both: int
    entropy_bits: tuple[float, float]
    contrast: tuple[float, float]
    mean_difference: float
    max_difference: float
    max_at_xy: tuple[float, float] | None

    @property
    def cells(self) -> int:
        """Number of cells of the lattice that contains both."""
        return int(self.states.sum())

    @property
    def same(self) -> int:
        """Number of cells that either map has observed and whose state is the same in both."""
        return int(np.trace(self.states)) - (self.cells - self.both - sum(self.only))

    @property
    def changed(self) -> dict[tuple[str, str], int]:
        """Number of cells that changed state, by (state in a, state in b), without zeros."""
        return {
            (STATES[i], STATES[j]): int(self.states[i, j])
            for i in range(3)
            for j in range(3)
            if i != j and self.states[i, j]
        }


@dataclass(frozen=True, slots=True)
class Difference:
    """ℓ_b − ℓ_a of each cell, ``log_odds`` (rows, cols) float32, and whether each map has observed it, bool."""

    geometry: GridGeometry
    log_odds: NDArray[np.float32]
    observed_a: NDArray[np.bool_]
    observed_b: NDArray[np.bool_]


def compare(a: OccupancyGrid, b: OccupancyGrid) -> Comparison:
    """Compare two maps and return the figures.

    Raises :class:`mapper.core.errors.ConfigError` if their cells do not coincide, and
    :class:`mapper.core.errors.LimitError` if the lattice that contains both is too large.
    """
    geometry, ((rows_a, cols_a), (rows_b, cols_b)) = on_one_lattice(a, b)
    place = np.array([*geometry.shape, rows_a.start, cols_a.start, rows_b.start, cols_b.start])
    thresholds = log_odds([FREE_THRESHOLD, OCCUPIED_THRESHOLD])
    priors = np.array([a.log_odds_prior, b.log_odds_prior], dtype=np.float32)
    states, seen = np.zeros((3, 3), dtype=np.int64), np.zeros(5, dtype=np.int64)
    sums = np.zeros(4)
    count_cells(a.log_odds, a.observed, b.log_odds, b.observed, place, priors, thresholds, states, seen, sums)
    both = int(seen[2])
    at = geometry.cell_to_world(seen[3:5])
    return Comparison(
        geometry,
        states,
        (int(seen[0]), int(seen[1])),
        both,
        (float(sums[0]), float(sums[1])),
        (wall_contrast(a), wall_contrast(b)),
        float(sums[2]) / max(both, 1),
        float(sums[3]),
        (float(at[0]), float(at[1])) if both else None,
    )


def difference(a: OccupancyGrid, b: OccupancyGrid, rows: slice | None = None) -> Difference:
    """Return ℓ_b − ℓ_a of every cell, or of the rows ``rows`` of the lattice that contains both maps.

    A cell outside a map has that map's prior. Raises the errors of :func:`compare`.
    """
    geometry, parts = on_one_lattice(a, b)
    band = slice(0, geometry.rows) if rows is None else rows
    sides = [_placed(grid, geometry, part, band) for grid, part in zip((a, b), parts, strict=True)]
    return Difference(sides[0].geometry, sides[1].log_odds - sides[0].log_odds, sides[0].observed, sides[1].observed)


def wall_contrast(grid: OccupancyGrid) -> float:
    """Return the contrast of walls, 0 to 1: the mean difference of p across the edges between walls and free space.

    An edge is between two neighbouring observed cells, one more likely occupied than not and the other less. A smeared
    wall has more such edges with smaller steps. 0 for a map without edges.
    """
    total = np.zeros(1)
    count = sum_edges(grid.log_odds, grid.observed, total)
    return float(total[0]) / count if count else 0.0


def _placed(grid: OccupancyGrid, geometry: GridGeometry, part: Part, band: slice) -> OccupancyGrid:
    """Return the rows ``band`` of a lattice in which ``grid`` occupies ``part``."""
    out = OccupancyGrid(geometry.band(band), grid.log_odds_prior)
    rows, cols = part
    first, stop = max(rows.start, band.start), min(rows.stop, band.stop)
    if first < stop:
        own, into = slice(first - rows.start, stop - rows.start), slice(first - band.start, stop - band.start)
        out.log_odds[into, cols], out.observed[into, cols] = grid.log_odds[own], grid.observed[own]
    return out
