"""What a message's range_min and range_max say of its readings, also where they cannot be meant as they stand.

Source: sensor_msgs/LaserScan and Range; REP 117, whose fixed-distance rangers state both as one distance.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping

#: How limits are understood that cannot be meant as they stand → the sentence on them.
UNLIMITED, INFINITE, SWAPPED, FIXED = "unlimited", "infinite", "swapped", "fixed"
_SENTENCES = {
    UNLIMITED: (
        "state a range_max of {range_max:g} m, which no sensor has: readings of any distance count, and the map's max "
        "range limits them."
    ),
    INFINITE: (
        "state no greatest distance (range_max inf): readings of any distance count, and the map's max range limits "
        "them."
    ),
    SWAPPED: (
        "state a range_min of {range_min:g} m above their range_max of {range_max:g} m: the two are taken the other "
        "way round."
    ),
    FIXED: (
        "state {range_max:g} m as range_min and range_max: they are of a ranger for one fixed distance (REP 117), "
        "whose −inf says that something is nearer and +inf that nothing is. No distance is measured, so it draws no "
        "walls; with no_return free what is +inf clears the cells up to there."
    ),
}


def usable_limits(range_min: float, range_max: float) -> tuple[float, float, str]:
    """Return the least and the greatest distance that count, metres, and how they were understood, "" as they stand.

    The greatest is inf where none is stated that can be.
    """
    least = range_min if 0.0 <= range_min < math.inf else 0.0
    if not range_max > 0.0:  # nan too
        return least, math.inf, UNLIMITED
    if range_max == math.inf:
        return least, math.inf, INFINITE
    if least > range_max:
        return range_max, least, SWAPPED
    if least == range_max:
        return 0.0, range_max, FIXED
    return least, range_max, ""


def notes_on_limits(topic: str, n_scans: int, stated: Mapping[tuple[float, float], int]) -> list[str]:
    """Return a note for each way in which limits cannot be meant as they stand.

    ``stated`` has the pairs range_min, range_max on ``topic`` and how many of the ``n_scans`` messages state each.
    """
    counts: Counter[str] = Counter()
    examples: dict[str, tuple[float, float]] = {}
    for pair, count in stated.items():
        how = usable_limits(*pair)[2]
        if how:
            counts[how] += count
            examples.setdefault(how, pair)
    return [
        f"{counted(counts[how], n_scans)} on {topic} "
        + _SENTENCES[how].format(range_min=examples[how][0], range_max=examples[how][1])
        for how in counts
    ]


def counted(some: int, of: int) -> str:
    """Return how many of a topic's messages it is, for the beginning of a sentence."""
    return f"All {of} messages" if some == of else f"{some} of the {of} messages"
