"""``/api/sessions/{id}/sensor``: map another sensor of a session's log, or change how its scans are cut from clouds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, Field, FiniteFloat

from server.http.clients import while_connected
from server.http.services import Logs, Sessions, Visitor
from server.http.session_access import writable_session
from server.sessions.commands import UseSensor
from server.sessions.view import LogView

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


class NewSensor(BaseModel, extra="forbid"):
    """The sensor of the log to map."""

    topic: str | None = Field(
        None,
        max_length=8000,
        description="Topic of the sensor; ' + ' between several makes one map of them; null: the log's default.",
    )
    cut: dict[str, FiniteFloat] | None = Field(
        None,
        max_length=20,
        description="How scans are cut out of clouds and depth images, see /api/parameters; else as by default.",
    )


@dataclass(frozen=True, slots=True)
class SensorAnswer:
    """The mapped sensor, null for the log's default, and the options for cutting its scans."""

    topic: str | None
    cut: dict[str, float]


@router.put("/{session_id}/sensor")
async def use(
    request: Request,
    library: Logs,
    sessions: Sessions,
    visitor: Visitor,
    session_id: str,
    body: NewSensor,
    name: Annotated[
        str | None, Query(max_length=100, description="Name under which /api/sessions/making/{name} has the progress.")
    ] = None,
) -> SensorAnswer:
    """Map another sensor of the session's log, or change the options for cutting scans; the time stays the same.

    This may require reading the recording, which is cancelled if the client disconnects.
    """
    of_log = writable_session(sessions, session_id)
    view = LogView(body.topic, cut=body.cut)
    cut = view.planar_cut

    async def read() -> None:
        with sessions.under_way.making(visitor, name) as making:
            making.watched = lambda: library.opening(of_log.log_id)
            log = await library.load(of_log.owner, of_log.log_id, body.topic, cut)
            await sessions.free_bytes(log, of_log.owner)
            of_log.session.enqueue(UseSensor(log, view))

    await while_connected(request, read())
    return SensorAnswer(body.topic, cut.values)
