"""Association of the poses of two trajectories by their nearest stamps.

Source: ``associate.py`` of the TUM RGB-D benchmark's tools (Sturm et al. 2012), and evo's ``sync.py``, whose rule is
used: each pose of the trajectory with fewer poses is paired with the nearest one of the other, which may be used
repeatedly.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.core.errors import ConfigError

MAX_DIFFERENCE_S = 0.01  #: seconds: evo's


def associate(
    reference_ns: Int64Array, estimate_ns: Int64Array, max_difference_s: float = MAX_DIFFERENCE_S, offset_s: float = 0.0
) -> Int64Array:
    """Return the pairs (k, 2) of matching indices into two lists of stamps (n,) and (m,), ns.

    ``offset_s`` seconds are added to the estimate's stamps first. The pairs are in the order of the shorter list (the
    estimate if both have the same length). As in evo, of two equally near stamps the earlier one is used, and of equal
    stamps the last; if stamps run backwards, it is the first in the list in both cases.

    Lists that are equal, element by element, are paired in order: a log's stamps may repeat or run backwards, and two
    trajectories of one log correspond by scan. evo also applies the rule above here.

    Raises :class:`ConfigError` for a difference that is negative or not finite, an offset that is not finite or beyond
    10⁹ s, and if nothing matches.
    """
    if not (np.isfinite(max_difference_s) and 0.0 <= max_difference_s <= 1e9):
        raise ConfigError(
            "evaluation.max_difference",
            f"The greatest difference of stamps must be 0 … 1e9 s, not {max_difference_s!r}.",
        )
    if not abs(offset_s) <= 1e9:
        raise ConfigError("evaluation.offset", f"The offset of the stamps must be at most 1e9 s, not {offset_s!r}.")
    shifted_ns = estimate_ns + round(offset_s * 1e9)
    if np.array_equal(reference_ns, shifted_ns):
        pairs = np.repeat(np.arange(len(reference_ns))[:, np.newaxis], 2, axis=1)
    elif len(shifted_ns) > len(reference_ns):
        pairs = _nearest(reference_ns, shifted_ns, max_difference_s)
    else:
        pairs = _nearest(shifted_ns, reference_ns, max_difference_s)[:, ::-1]
    if not len(pairs):
        raise ConfigError(
            "evaluation.no_pairs",
            f"No stamps of the two trajectories are within {max_difference_s:g} s of one another: "
            f"{_span(reference_ns)} and {_span(shifted_ns)}.",
        )
    return np.ascontiguousarray(pairs, dtype=np.int64)


def _nearest(few: Int64Array, many: Int64Array, max_difference_s: float) -> Int64Array:
    """Return for each of ``few`` its index and that of the nearest of ``many``, if it is near enough."""
    if not len(many):
        return np.empty((0, 2), dtype=np.int64)
    order = np.argsort(many, kind="stable")
    stamps = many[order]
    after = np.searchsorted(stamps, few, side="right")
    low, high = np.clip(after - 1, 0, None), np.clip(after, None, len(stamps) - 1)
    to_low, to_high = np.abs(few - stamps[low]), np.abs(stamps[high] - few)
    takes_low = to_low <= to_high
    if (np.diff(many) < 0).any():
        low = np.searchsorted(stamps, stamps[low])
        takes_low = (to_low < to_high) | ((to_low == to_high) & (order[low] < order[high]))
    best = np.where(takes_low, low, high)
    near = np.flatnonzero(np.minimum(to_low, to_high) <= round(max_difference_s * 1e9))
    return np.column_stack([near, order[best[near]]])


def _span(stamps_ns: Int64Array) -> str:
    if not len(stamps_ns):
        return "no stamp"
    return f"{stamps_ns.min() / 1e9:.3f} … {stamps_ns.max() / 1e9:.3f} s"
