"""Published errors over known relations between places, for comparison.

They are mean errors as defined by Kümmerle et al. (:mod:`mapper.evaluation.relations`). How their authors determined
the poses at the relations' stamps is unknown. On a log with repeated stamps that alone makes a difference of
centimetres, so figures with another policy are not a bound. Results measured by this project state the policy.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

KUEMMERLE = "Kümmerle et al. 2009, On measuring the accuracy of SLAM algorithms"
HESS = "Hess et al. 2016, Real-time loop closure in 2D lidar SLAM"
MEASURED = "measured by gridbloom evaluate: the poses of the log intel-corrected"
PAPER, RECORDS = "paper", "records"


@dataclass(frozen=True, slots=True)
class PublishedResult:
    """The mean error of a program's poses over the relations of a log, metres and degrees; None: not published.

    ``policy`` is the mapping of stamps, as in :attr:`mapper.evaluation.relations.RelationErrors.policy`, or "paper" for
    that of the source. ``count`` is the number of relations, if known.
    """

    program: str
    translation: float
    translation_std: float | None
    rotation: float | None
    rotation_std: float | None
    policy: str
    source: str
    count: int | None = None


PUBLISHED: Mapping[str, tuple[PublishedResult, ...]] = {
    "intel": (
        PublishedResult("scan matching", 0.220, 0.296, None, None, PAPER, KUEMMERLE),
        PublishedResult("RBPF, 50 particles", 0.070, 0.083, None, None, PAPER, KUEMMERLE),
        PublishedResult("graph mapping", 0.031, 0.026, 1.3, 4.7, PAPER, KUEMMERLE),
        PublishedResult("Cartographer", 0.0229, 0.0239, 0.453, 1.335, PAPER, HESS),
        PublishedResult("gmapping", 0.0299, None, 1.105, None, RECORDS, MEASURED, 2984),
        PublishedResult("gmapping, unambiguous", 0.0280, None, 1.029, None, RECORDS, MEASURED, 1050),
    ),
    "fr079": (PublishedResult("Cartographer", 0.0452, None, None, None, PAPER, HESS),),
}


def benchmark_named(text: str) -> str | None:
    """Return the benchmark log of a file, by a word of its name, such as ``intel.relations``; None if there is none."""
    words = re.split(r"[^a-z0-9]+", text.lower())
    return next((name for name in PUBLISHED if name in words), None)
