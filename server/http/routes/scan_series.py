"""``/api/sessions/{id}/scan-series``: speed, turn rate and returns of a session's log from scan to scan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fastapi import APIRouter, Request
from fastapi.responses import Response

from mapper.io.contents.scan_series import has_times, plot_origin_ns, scan_series
from mapper.sensors.scan import ScanLog
from server.http.clients import in_turn
from server.http.guests import GuestRight, guests_may
from server.http.series_answer import BUCKETS, Buckets, Seconds, SeriesAnswer, json_answer
from server.http.services import RequestWork, Sessions, Visitor
from server.http.session_access import part_of_log
from server.sessions.parts import Recording

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanSeries(SeriesAnswer):
    """The series of a log's scans along a trajectory. ``times`` are scan numbers if ``axis`` is "scan"."""

    axis: Literal["time", "scan"]
    trajectory: str


@router.get("/{session_id}/scan-series", response_model=ScanSeries)
@guests_may(GuestRight.LINKED_SESSION)
async def of_scans(
    request: Request,
    sessions: Sessions,
    visitor: Visitor,
    work: RequestWork,
    session_id: str,
    start: Seconds | None = None,
    end: Seconds | None = None,
    buckets: Buckets = BUCKETS,
) -> Response:
    """Return speed, turn rate, share of returns, pose step and interval at the log's scans, at most two per bucket.

    The poses are those of the session's current trajectory. ``axis`` is "time", in seconds since the first scan, or
    "scan" for a log without times, whose ``times`` are scan numbers.
    """
    session = sessions.get(session_id)
    recording = part_of_log(session, Recording, "Only the recording of a log has scans to plot, not a live world.")
    log, trajectory = recording.log, recording.trajectory
    return await in_turn(request, work, visitor, lambda: json_answer(_answer(log, trajectory, start, end, buckets)))


def _answer(log: ScanLog, trajectory: str, start: float | None, end: float | None, buckets: int) -> ScanSeries:
    axis = "time" if has_times(log) else "scan"
    series = scan_series(log, trajectory)
    return ScanSeries.of(series, plot_origin_ns(log), start, end, buckets, axis=axis, trajectory=trajectory)
