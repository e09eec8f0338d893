"""Two maps of one place, cell by cell: what changed from the one to the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyGrid
from mapper.merge import on_one_lattice
from mapper.metrics import entropy

STATES = (("free", FREE), ("occupied", OCCUPIED), ("unknown", UNKNOWN))


@dataclass(frozen=True, slots=True)
class Comparison:
    """What is different in ``b`` from ``a``, over the cells of both.

    ``log_odds`` (rows, cols) float32 is ℓ_b − ℓ_a, a cell that a map does not have counting as its prior; ``changed``
    counts the cells that went from one state to another, by (state in a, state in b); ``same`` those that did not
    among the observed ones of either. ``entropy_bits`` and ``contrast`` are those of a and of b: the entropy of the
    cells that either has observed, and :func:`wall_contrast`.
    """

    geometry: GridGeometry
    log_odds: NDArray[np.float32]
    changed: dict[tuple[str, str], int]
    same: int
    entropy_bits: tuple[float, float]
    contrast: tuple[float, float]


def compare(a: OccupancyGrid, b: OccupancyGrid) -> Comparison:
    """Compare two maps. Raises :class:`mapper.errors.ConfigError` where their cells do not coincide."""
    geometry, parts = on_one_lattice(a, b)
    on_both = [_placed(grid, geometry, part) for grid, part in zip((a, b), parts, strict=True)]
    seen = on_both[0].observed | on_both[1].observed
    before, after = (grid.classify() for grid in on_both)
    changed = {
        (name_a, name_b): count
        for name_a, value_a in STATES
        for name_b, value_b in STATES
        if value_a != value_b and (count := int(np.count_nonzero((before == value_a) & (after == value_b))))
    }
    bits = [float(entropy(grid.log_odds[seen]).sum()) for grid in on_both]
    contrast = [wall_contrast(grid) for grid in on_both]
    return Comparison(
        geometry,
        on_both[1].log_odds - on_both[0].log_odds,
        changed,
        int(np.count_nonzero(seen & (before == after))),
        (bits[0], bits[1]),
        (contrast[0], contrast[1]),
    )


def wall_contrast(grid: OccupancyGrid) -> float:
    """Return how sharply walls stand out, 0 … 1: the mean difference of p across the edges between wall and space.

    An edge lies between two neighbouring cells, both observed, one of which is more likely occupied than not and the
    other less. A wall that is smeared has more such edges, and smaller steps at them; 0 for a map without any.
    """
    p, seen = grid.p_occ, grid.observed
    steps = []
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1, :], np.s_[1:, :])):
        edge = seen[here] & seen[there] & ((p[here] > 0.5) != (p[there] > 0.5))
        steps.append(np.abs(p[here] - p[there])[edge])
    found = np.concatenate(steps)
    return float(found.mean()) if len(found) else 0.0


def _placed(grid: OccupancyGrid, geometry: GridGeometry, part: tuple[slice, slice]) -> OccupancyGrid:
    out = OccupancyGrid(geometry, grid.log_odds_prior)
    out.log_odds[part], out.observed[part] = grid.log_odds, grid.observed
    return out
