"""Readings as text, for the table: by the kernel, and by NumPy's rounding and an encoder of JSON."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from hypothesis import strategies as st

from mapper.core.kernels.decimals import GREATEST, MOST_BYTES, write_thousandths

LOW, HIGH = 0.1, 5e8
SPECIAL = (np.nan, np.inf, -np.inf, -1.0, 0.0, 0.1, 1.0, 9.9995, 99.9994, 0.9996, 1234.5, 5e8, GREATEST / 2)


@st.composite
def readings(draw: st.DrawFn) -> np.ndarray:
    """Readings with many near the half of a thousandth, or of another number of digits once rounded."""
    reading = (
        st.sampled_from(SPECIAL)
        | st.integers(0, 40_000).map(lambda n: n / 2000.0)
        | st.floats(0.0, 40.0)
        | st.floats(0.0, 6e8)
    )
    return np.array(draw(st.lists(reading, max_size=40)), dtype=np.float32)


def text_by_kernel(values: np.ndarray) -> tuple[Any, ...]:
    out = np.empty(2 + MOST_BYTES * len(values), dtype=np.uint8)
    return (out[: write_thousandths(values, LOW, HIGH, out)].tobytes(),)


def text_by_encoder(values: np.ndarray) -> tuple[Any, ...]:
    rounded = np.round(values.astype(np.float64), 3).tolist()
    measured = (values.astype(np.float64) >= LOW) & (values.astype(np.float64) <= HIGH)
    return (msgspec.json.encode([one if ok else None for one, ok in zip(rounded, measured, strict=True)]),)
