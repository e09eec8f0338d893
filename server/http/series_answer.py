"""A series of numbers over time as JSON, downsampled to the width of a plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Self

import msgspec
import numpy as np
from fastapi import Query
from fastapi.responses import Response
from pydantic import FiniteFloat

from mapper.core.array_types import Int64Array
from mapper.io.contents.downsampling import min_max
from mapper.io.contents.model import Series
from mapper.sensors.gaps import are_gaps

Seconds = Annotated[FiniteFloat, Query(ge=-1e10, le=1e10)]
Buckets = Annotated[int, Query(ge=1, le=4000, description="Intervals of time, each with at most two rows.")]

BUCKETS = 800


@dataclass(frozen=True, slots=True)
class SeriesColumn:
    """One number over time."""

    label: str
    unit: str
    plot: str
    values: list[float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesAnswer:
    """The numbers of a topic's messages, or of a log's scans: ``times`` in seconds, ``samples`` before downsampling.

    ``gaps`` are pauses of the recording, from one sample to the next, in seconds.
    """

    topic: str
    type: str
    samples: int
    gaps: list[tuple[float, float]]
    times: list[float]
    columns: list[SeriesColumn]

    @classmethod
    def of(
        cls,
        series: Series,
        origin_ns: int,
        start: float | None,
        end: float | None,
        buckets: int,
        *,
        evenly: bool = False,
        **more: str,
    ) -> Self:
        """Return the rows of a series from ``start`` to ``end``, seconds since ``origin_ns``; None: its ends.

        There are at most ``2 · buckets`` rows, with the least and the greatest value of each bucket, or if ``evenly``
        complete rows of samples; NaN becomes null. ``gaps`` are the ``buckets`` longest. ``more`` are fields of a
        subclass.
        """
        all_stamps, all_values = _between(series, origin_ns, start, end)
        if evenly:
            every = slice(None, None, max(1, -(-len(all_stamps) // (2 * buckets))))
            stamps, values = all_stamps[every], all_values[every]
        else:
            stamps, values = min_max(all_stamps, all_values, buckets)
        is_double = values.dtype == np.float64
        return cls(
            topic=series.topic,
            type=series.type,
            samples=len(all_stamps),
            gaps=_gaps(series.stamps_ns, all_stamps, origin_ns, buckets),
            times=((stamps - origin_ns) * 1e-9).round(6).tolist(),
            columns=[
                SeriesColumn(
                    label=column.label,
                    unit=column.unit,
                    plot=column.plot,
                    values=[_written(value, is_double=is_double) for value in values[:, n].tolist()],
                )
                for n, column in enumerate(series.columns)
            ],
            **more,
        )


def _written(value: float, *, is_double: bool) -> float | None:
    """Return a number without the digits beyond its precision; None if JSON cannot represent it."""
    if not math.isfinite(value):
        return None
    return float(f"{value:.12g}") if is_double else round(value, 6)


def json_answer(answer: object, status_code: int = 200) -> Response:
    """Return an answer as JSON. Long ones are encoded where they were computed, not on the event loop."""
    return Response(msgspec.json.encode(answer), status_code=status_code, media_type="application/json")


def _between(series: Series, origin_ns: int, start: float | None, end: float | None) -> tuple[Any, Any]:
    """Return the samples from ``start`` to ``end``, and one more at each end, so that lines reach the edge."""
    low, high = 0, len(series.stamps_ns)
    if start is not None:
        low = max(0, int(np.searchsorted(series.stamps_ns, origin_ns + round(start * 1e9), side="left")) - 1)
    if end is not None:
        high = int(np.searchsorted(series.stamps_ns, origin_ns + round(end * 1e9), side="right")) + 1
    return series.stamps_ns[low:high], series.values[low:high]


def _gaps(of_all: Int64Array, stamps_ns: Int64Array, origin_ns: int, most: int) -> list[tuple[float, float]]:
    """Return the gaps in ``stamps_ns``, ascending, in seconds, relative to the usual interval of the whole series."""
    is_gap = are_gaps(np.diff(of_all).astype(np.float64) * 1e-9)
    first = int(np.searchsorted(of_all, stamps_ns[0])) if len(stamps_ns) else 0
    starts = np.flatnonzero(is_gap[first : first + max(0, len(stamps_ns) - 1)])
    pauses = stamps_ns[starts + 1] - stamps_ns[starts]
    longest = np.sort(starts[np.argsort(-pauses, kind="stable")[:most]])
    ends = np.stack([stamps_ns[longest], stamps_ns[longest + 1]], axis=-1)
    return [(float(a), float(b)) for a, b in ((ends - origin_ns) * 1e-9).round(6)]
