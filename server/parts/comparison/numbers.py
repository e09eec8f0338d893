"""The numbers of a comparison of two maps."""

from __future__ import annotations

from mapper.grid.compare import Comparison
from server.stream.message_parts import Numbers
from server.stream.messages import ComparisonMessage


def numbers(comparison: Comparison) -> Numbers:
    """Return the numbers of a comparison, rounded."""
    entropy_a, entropy_b = comparison.entropy_bits
    contrast_a, contrast_b = comparison.contrast
    at = comparison.max_at_xy
    return Numbers(
        cells=comparison.cells,
        states=comparison.states.tolist(),
        same=comparison.same,
        only=comparison.only,
        both=comparison.both,
        entropy_bits=(round(entropy_a, 1), round(entropy_b, 1)),
        contrast=(round(contrast_a, 4), round(contrast_b, 4)),
        mean_difference=round(comparison.mean_difference, 4),
        max_difference=round(comparison.max_difference, 4),
        max_at=None if at is None else (round(at[0], 4), round(at[1], 4)),
    )


def comparison_message(
    index: int, comparison: Comparison | None = None, refused: str | None = None
) -> ComparisonMessage:
    """Return a ``comparison`` message: the numbers, or the reason why the maps cannot be compared."""
    return ComparisonMessage(index, refused, None if comparison is None else numbers(comparison))
