"""Errors of poses against another trajectory, or against known relations between places."""

from mapper.evaluation.alignment import ALIGNMENTS, Alignment, align
from mapper.evaluation.association import associate
from mapper.evaluation.pairs import pairs_over
from mapper.evaluation.published import PUBLISHED, PublishedResult, benchmark_named
from mapper.evaluation.relations import RelationErrors, Relations, evaluate_relations
from mapper.evaluation.same_path import first_pair
from mapper.evaluation.statistics import ErrorSeries, ErrorStatistics
from mapper.evaluation.trajectory_error import (
    Comparison,
    ComparisonOptions,
    absolute_errors,
    compare_trajectories,
    relative_errors,
)

__all__ = [
    "ALIGNMENTS",
    "PUBLISHED",
    "Alignment",
    "Comparison",
    "ComparisonOptions",
    "ErrorSeries",
    "ErrorStatistics",
    "PublishedResult",
    "RelationErrors",
    "Relations",
    "absolute_errors",
    "align",
    "associate",
    "benchmark_named",
    "compare_trajectories",
    "evaluate_relations",
    "first_pair",
    "pairs_over",
    "relative_errors",
]
