"""``/api/sessions/{id}/merge``: bring a session's log and another one of the same place into one frame."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Any

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from mapper.core.errors import MapperError
from server.http.routes.trajectories import update_sessions
from server.http.services import Logs, Sessions
from server.http.session_access import writable_session
from server.library.processing.merging import MergeReport, MergeRequest, MergeStatus

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

_tasks: set[asyncio.Task[None]] = set()  # of merges that have ended: asyncio itself keeps no reference


class Other(BaseModel):
    """The log to merge with."""

    model_config = ConfigDict(extra="forbid")

    log: str = Field(max_length=64, description="Id of the other log.")
    topic: str | None = Field(None, max_length=400, description="Sensor of it, if it has several.")
    cut: dict[str, FiniteFloat] | None = Field(
        None,
        max_length=20,
        description="How its scans are cut out of clouds and depth images, see /api/parameters; else as here.",
    )
    mapping: dict[str, Any] | None = Field(
        None,
        max_length=50,
        description="Parameters of its map, see /api/parameters: its mount and its time offset are used; else as here.",
    )


@router.post("/{session_id}/merge", status_code=202)
async def begin(library: Logs, sessions: Sessions, session_id: str, wanted: Other) -> MergeStatus:
    """Begin to align the session's log and another one of the same place, as a job.

    Each is corrected by SLAM, their maps are laid on one another, and their scans joined in one graph. Both logs then
    have a trajectory ``merged`` in one frame, and one more log has the scans of both along it, with a trajectory
    ``SLAM`` that has their pose graph. Scans of clouds and depth images are cut as in the session, and the mount and
    the time offset are those of its map.
    """
    of_log = writable_session(sessions, session_id)
    view = of_log.recording.view()
    owner, first = of_log.owner, of_log.log_id

    async def tell() -> None:
        with suppress(MapperError):  # a log was deleted meanwhile
            for log_id in (first, wanted.log):
                await update_sessions(library, sessions, owner, log_id)

    def notify(report: MergeReport | None) -> None:
        if report is not None:
            return
        task = asyncio.create_task(tell())
        _tasks.add(task)
        task.add_done_callback(_tasks.discard)

    cut = view.cut if wanted.cut is None else wanted.cut
    mapping = view.values if wanted.mapping is None else wanted.mapping
    request = MergeRequest(wanted.log, view.topic, wanted.topic, view.cut, cut, view.values, mapping)
    state = await library.merges.begin(owner, first, request)
    library.merges.listen(owner, first, notify)
    return state


@router.get("/{session_id}/merge")
async def state(library: Logs, sessions: Sessions, session_id: str) -> MergeStatus:
    """Return the progress and the result of the merge of the session's log."""
    of_log = writable_session(sessions, session_id)
    return library.merges.state(of_log.owner, of_log.log_id)


@router.delete("/{session_id}/merge")
async def cancel(library: Logs, sessions: Sessions, session_id: str) -> MergeStatus:
    """Cancel the merge of the session's log, if it is queued or running."""
    of_log = writable_session(sessions, session_id)
    return await library.merges.cancel(of_log.owner, of_log.log_id)
