"""Cell-by-cell counts for two maps on one lattice, and the edges between walls and free space of one map."""

from __future__ import annotations

from math import exp

import numpy as np

from mapper.core.array_types import BoolArray, Float32Array, Float64Array, Int64Array
from mapper.core.jit import jit
from mapper.grid.kernels.map_statistics import SLOTS, _entropy, _slot


@jit
def _state(log_odds: float, free_below: float, occupied_above: float) -> int:
    """Return the state of an observed cell: 0 free, 1 occupied, 2 between."""
    if log_odds < free_below:
        return 0
    return 1 if log_odds > occupied_above else 2


@jit
def count_cells(
    log_odds_a: Float32Array,
    observed_a: BoolArray,
    log_odds_b: Float32Array,
    observed_b: BoolArray,
    place: Int64Array,
    priors: Float32Array,
    thresholds: Float64Array,
    states: Int64Array,
    seen: Int64Array,
    sums: Float64Array,
) -> None:
    """Count the cells of a lattice that contains two maps, both (rows, cols) float32 with their observed flags.

    ``place`` is (rows, cols) of the lattice, then the (row, col) in it of the first map's cell (0, 0), then the
    second's. A cell outside a map counts as never observed and has the map's prior, ``priors`` (2,). An observed cell
    is free below and occupied above the log-odds ``thresholds`` (2,), unknown between; others are unknown.

    Written: ``states`` (3, 3) by (state in a, state in b), each free, occupied, unknown; ``seen`` (5,): cells observed
    in a only, in b only, in both, and row and column of the greatest |ℓ_b − ℓ_a| (−1 if none is observed in both);
    ``sums`` (4,): the entropy in bits of a and of b over the cells that either observed, and the sum and maximum of
    |ℓ_b − ℓ_a| over those that both observed.
    """
    keys = np.zeros(SLOTS, dtype=np.uint32)
    slots = np.zeros(SLOTS, dtype=np.float64)
    slots[0] = _entropy(0.0)  # all bits of 0.0 are zero; every other key differs from an empty slot
    rows, cols = place[0], place[1]
    free_below, occupied_above = thresholds[0], thresholds[1]
    values = np.empty(2, dtype=np.float32)
    bits = values.view(np.uint32)
    seen[3] = seen[4] = -1
    for r in range(rows):
        row_a, row_b = r - place[2], r - place[4]
        has_a, has_b = 0 <= row_a < log_odds_a.shape[0], 0 <= row_b < log_odds_b.shape[0]
        for c in range(cols):
            col_a, col_b = c - place[3], c - place[5]
            in_a = has_a and 0 <= col_a < log_odds_a.shape[1]
            in_b = has_b and 0 <= col_b < log_odds_b.shape[1]
            seen_a = in_a and observed_a[row_a, col_a]
            seen_b = in_b and observed_b[row_b, col_b]
            if not (seen_a or seen_b):
                continue  # counted below as the remainder
            values[0] = log_odds_a[row_a, col_a] if in_a else priors[0]
            values[1] = log_odds_b[row_b, col_b] if in_b else priors[1]
            for i in range(2):
                slot = _slot(bits[i])
                if keys[slot] != bits[i]:
                    keys[slot] = bits[i]
                    slots[slot] = _entropy(values[i])
                sums[i] += slots[slot]
            a, b = float(values[0]), float(values[1])
            state_a = _state(a, free_below, occupied_above) if seen_a else 2
            state_b = _state(b, free_below, occupied_above) if seen_b else 2
            states[state_a, state_b] += 1
            if seen_a and seen_b:
                seen[2] += 1
                difference = abs(b - a)
                sums[2] += difference
                if difference > sums[3] or seen[3] < 0:
                    sums[3] = difference
                    seen[3], seen[4] = r, c
            elif seen_a:
                seen[0] += 1
            else:
                seen[1] += 1
    states[2, 2] += rows * cols - seen[0] - seen[1] - seen[2]


@jit
def sum_edges(log_odds: Float32Array, observed: BoolArray, sums: Float64Array) -> int:
    """Return the number of edges between walls and space: observed neighbours of which one has ℓ > 0 and one does not.

    ``log_odds`` and ``observed`` (rows, cols). ``sums[0]`` receives the sum of |Δp| over the edges.
    """
    rows, cols = log_odds.shape
    count = 0
    total = 0.0
    for r in range(rows):
        for c in range(cols):
            if not observed[r, c]:
                continue
            here = log_odds[r, c]
            for there_r, there_c in ((r, c + 1), (r + 1, c)):
                if there_r >= rows or there_c >= cols or not observed[there_r, there_c]:
                    continue
                there = log_odds[there_r, there_c]
                if (here > 0.0) != (there > 0.0):
                    count += 1
                    total += abs(1.0 / (1.0 + exp(-float(here))) - 1.0 / (1.0 + exp(-float(there))))
    sums[0] = total
    return count
