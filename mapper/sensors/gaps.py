"""Detection of gaps in a recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST_S = 1.0  #: shorter pauses are not gaps
USUAL_PAUSES = 5.0  #: minimum length of a gap, in usual pauses


def are_gaps(pauses_s: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which pauses between consecutive messages, seconds (n,), are gaps of the recording.

    A gap is longer than one second and than five times the usual pause, which is the median of the non-zero pauses.
    """
    passed = pauses_s[pauses_s > 0.0]
    usual = float(np.median(passed)) if passed.size else 0.0
    return pauses_s > max(LEAST_S, USUAL_PAUSES * usual)
