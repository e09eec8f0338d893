"""``/api/sessions/{id}/scan-series``: speed, turn rate and returns of a session's log from scan to scan."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

from mapper.core.errors import MapperError
from mapper.io.contents.scan_series import has_times, scan_series
from mapper.sensors.scan import ScanLog
from server.http.guests import GuestRight, guests_may
from server.http.request_work import in_turn
from server.http.series_answer import BUCKETS, Buckets, Seconds, series_answer
from server.http.services import RequestWork, Sessions, Visitor
from server.sessions.parts import Recording

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


@router.get("/{session_id}/scan-series")
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
) -> JSONResponse:
    """Return speed, turn rate, share of returns, pose step and interval at the log's scans, at most two per bucket.

    The poses are those of the session's present trajectory. ``axis`` is "time", in seconds since the first scan, or
    "scan" for a log without times, whose ``times`` are numbers of scans.
    """
    recording = sessions.get(session_id).model.find(Recording)
    if recording is None:
        raise MapperError("session.not_a_log", "Only the recording of a log has scans to plot, not a live world.")
    log, trajectory = recording.log, recording.trajectory
    return await in_turn(request, work, visitor, lambda: JSONResponse(_answer(log, trajectory, start, end, buckets)))


def _answer(log: ScanLog, trajectory: str, start: float | None, end: float | None, buckets: int) -> dict[str, Any]:
    is_timed = has_times(log)
    origin_ns = int(log.stamps_ns.min()) if is_timed else 0
    answer = series_answer(scan_series(log, trajectory), origin_ns, start, end, buckets)
    return answer | {"axis": "time" if is_timed else "scan", "trajectory": trajectory}
