"""``/api/sessions/{id}/doctor``: the diagnosis of the log that a session shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from fastapi import APIRouter, Query, Request
from pydantic import Field

from mapper.core.parameter import Values
from mapper.io.logs.summary import recorded_seconds
from server.http.clients import while_connected
from server.http.guests import GuestRight, guests_may
from server.http.services import Sessions, Visitor
from server.http.session_access import part_of_log
from server.sessions.parts import Recording

if TYPE_CHECKING:
    from mapper.diagnosis import Diagnosis

router = APIRouter(prefix="/api", tags=["sessions"])


EventKind = Literal["pushed", "slipped", "lifted", "clock", "gap"]


@dataclass(frozen=True, slots=True)
class FindingAnswer:
    """A finding of an examination. ``sensor`` is empty for a log with one sensor.

    ``possible`` marks uncertain findings. ``sure`` is 0 to 1, ``scans`` are numbered from 0, ``seconds`` are their
    times, ``parameters`` are values of mapping parameters that would help.
    """

    check: str
    sentence: str
    advice: str
    sure: float
    scans: tuple[int, ...]
    parameters: Values | None
    sensor: str
    possible: bool
    seconds: list[float]


@dataclass(frozen=True, slots=True)
class LogEvent:
    """An event of a log: the robot was moved without its wheels, its clock was set, or there is a gap in it."""

    kind: EventKind
    seconds: Annotated[float, Field(description="begin in recorded time, s")]
    until_s: Annotated[float, Field(description="end in recorded time, s")]
    time: Annotated[str, Field(description="begin in recorded time, m:ss.mmm")]
    utc: Annotated[str | None, Field(description="begin in UTC, ISO 8601; null where the log's clock does not tell it")]
    stamp_ns: Annotated[int | None, Field(description="begin on the log's clock, ns")]
    scan: Annotated[int, Field(description="last scan before it, from 0")]
    until_scan: Annotated[int, Field(description="first scan after it")]
    ahead_m: Annotated[float | None, Field(description="motion by the scans less that by the wheels: ahead, m")]
    left_m: Annotated[float | None, Field(description="the same to the left, m")]
    turned_rad: Annotated[float | None, Field(description="the same, counter-clockwise, rad")]
    distance_m: Annotated[float | None, Field(description="length of it, m")]
    direction: Annotated[
        Literal["ahead", "behind", "left", "right"] | None, Field(description="side of the robot to which it went")
    ]
    step_s: Annotated[float, Field(description="by how much the clock was set, s")]
    moved_m: Annotated[
        float | None, Field(description="how far the robot came in a gap by its poses, m; null where they do not tell")
    ]
    sentence: Annotated[str, Field(description="when and what happened, in words")]
    what: Annotated[str, Field(description="the same without the time, with which the sentence begins")]


@dataclass(frozen=True, slots=True)
class DoctorAnswer:
    """The diagnosis of a log along a trajectory: findings, causes first, and events by time."""

    trajectory: str
    findings: list[FindingAnswer]
    events: list[LogEvent]


@router.get("/sessions/{session_id}/doctor")
@guests_may(GuestRight.LINKED_SESSION)
async def doctor(
    request: Request,
    sessions: Sessions,
    visitor: Visitor,
    session_id: str,
    name: Annotated[
        str | None, Query(max_length=100, description="Name under which /api/sessions/making/{name} has the progress.")
    ] = None,
) -> DoctorAnswer:
    """Return the diagnosis of the session's log with its current trajectory, and the events of its recording.

    ``seconds`` of a finding are the recorded times of its ``scans`` since the log's first scan. The examination ends
    when every client that waits for it has disconnected.
    """
    session = sessions.get(session_id)
    recording = part_of_log(session, Recording, "Only a log can be examined, not a simulation.")
    trajectory = recording.trajectory  # it may change during the examination
    with sessions.under_way.making(visitor, name) as making:
        making.watched = lambda: ("Examining the log", recording.examined_share)
        diagnosis = await while_connected(request, recording.examined())
    return doctor_answer(recording, trajectory, diagnosis)


def doctor_answer(recording: Recording, trajectory: str, diagnosis: Diagnosis) -> DoctorAnswer:
    """Return the diagnosis of a session's log along a trajectory as an answer of the HTTP interface."""
    seconds = recorded_seconds(recording.log)
    return DoctorAnswer(
        trajectory=trajectory,
        findings=[
            FindingAnswer(**finding.public(), seconds=[round(float(seconds[scan]), 3) for scan in finding.scans])
            for finding in diagnosis.findings
        ],
        events=[LogEvent(**event.public()) for event in diagnosis.events],
    )
