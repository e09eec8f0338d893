"""Which pauses of a recording are gaps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST_S = 1.0  #: shorter pauses are no gaps
USUAL_PAUSES = 5.0  #: least length of a gap, in usual pauses


def are_gaps(pauses_s: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which of the pauses between consecutive messages, seconds (n,), are gaps of the recording.

    Those of more than a second and of more than five times the usual pause, the median of those that are not zero.
    """
    passed = pauses_s[pauses_s > 0.0]
    usual = float(np.median(passed)) if passed.size else 0.0
    return pauses_s > max(LEAST_S, USUAL_PAUSES * usual)
