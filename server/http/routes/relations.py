"""``/api/sessions/{id}/relations``: the score of a log's poses against known relations, beside published results."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request

from server.http.routes.clients import client_address, while_connected
from server.http.services import Logs, Sessions, Visitor
from server.http.session_access import writable_session
from server.library.processing.relation_scores import PoseScore, relations_text

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


@router.put("/{session_id}/relations")
async def score(
    request: Request,
    library: Logs,
    sessions: Sessions,
    visitor: Visitor,
    session_id: str,
    name: Annotated[str, Query(max_length=200, description="Name of the file, as intel.relations.")] = "relations",
) -> PoseScore:
    """Return the mean errors of the trajectory in use over known relations: the body is their file.

    The definitions are those of ``gridbloom evaluate --relations``. The file is not kept.
    """
    of_log = writable_session(sessions, session_id)
    recording = of_log.recording
    log, trajectory, topic = recording.log, recording.trajectory, recording.view().topic
    text = await relations_text(request.stream())
    record = library.get(of_log.owner, of_log.log_id)
    score = library.scores.score(record, visitor, log, trajectory, text, name, topic, address=client_address(request))
    return await while_connected(request, score)
