"""Score of a puzzle's map: agreement with the reference, sharpness, entropy, and points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.grid.compare import wall_contrast
from mapper.grid.metrics import map_metrics, wall_agreement, wall_points

#: Weights of the measures in the repair, and the minimum improvement from the faulty to the repaired map for a measure
#: to count.
WEIGHTS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"agreement": (0.6, 0.03), "sharpness": (0.2, 0.01), "entropy": (0.2, 0.01)}
)
CAUSE_POINTS, REPAIR_POINTS = 40, 60
WRONG_POINTS = HINT_POINTS = 10  #: penalty for each wrong answer and each hint
REPAIRED = 0.9  #: fraction of the repair at which it is done


@dataclass(frozen=True, slots=True)
class Measures:
    """Measures of one map.

    ``agreement`` is the F-score of its walls against the reference, 0 to 1 (:func:`wall_agreement`), ``sharpness`` the
    contrast of its walls, 0 to 1 (:func:`wall_contrast`), ``entropy`` the mean entropy of its observed cells, bits.
    """

    agreement: float
    sharpness: float
    entropy: float


def measures_of(grid: OccupancyGrid, reference: NDArray[np.float64]) -> Measures:
    """Return the measures of a map; ``reference`` (n, 2) are points of the correct walls, metres."""
    metrics = map_metrics(grid)
    observed = grid.log_odds.size - metrics.never_observed
    return Measures(
        wall_agreement(wall_points(grid), reference),
        wall_contrast(grid),
        metrics.entropy_bits / observed if observed else 1.0,
    )


def repair_shares(spoiled: Measures, repaired: Measures, now: Measures) -> dict[str, float]:
    """Return each measure's progress from the faulty to the repaired map, 0 to 1.

    Measures that do not improve by the minimum in :data:`WEIGHTS` are omitted.
    """
    shares: dict[str, float] = {}
    for name, (_, least) in WEIGHTS.items():
        sign = -1.0 if name == "entropy" else 1.0
        first, last, present = (sign * getattr(figures, name) for figures in (spoiled, repaired, now))
        if last - first >= least:
            shares[name] = float(np.clip((present - first) / (last - first), 0.0, 1.0))
    return shares


def repair_share(shares: Mapping[str, float]) -> float:
    """Return the weighted mean of :func:`repair_shares`; 1 if no measure can be improved."""
    total = sum(WEIGHTS[name][0] for name in shares)
    return sum(WEIGHTS[name][0] * share for name, share in shares.items()) / total if total else 1.0


def points(*, is_named: bool, repair: float, wrong: int, hints: int, can_repair: bool) -> int:
    """Return the points, 0 to 100: for the cause and for the best repair so far, minus wrong answers and hints.

    ``repair`` is :func:`repair_share`. If nothing can be repaired, the cause alone is worth 100.
    """
    cause = CAUSE_POINTS + (0 if can_repair else REPAIR_POINTS)
    earned = cause * is_named + (round(REPAIR_POINTS * repair) if can_repair else 0)
    return max(0, earned - WRONG_POINTS * wrong - HINT_POINTS * hints)
