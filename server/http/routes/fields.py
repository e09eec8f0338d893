"""``/api/sessions/{id}/contents/fields``: the numbers in the messages of a session's recording, for plots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Query, Response

from mapper.core.errors import MapperError
from mapper.io.contents.carmen_lines import CARMEN_LINE
from mapper.io.contents.downsampling import derivative, moving_average, unit_of_rate
from mapper.io.contents.model import Column, Contents, Series
from mapper.io.contents.scan_series import plot_origin_ns
from server.http.computed_series import COMPUTED, computed_fields, computed_series, recording_of
from server.http.guests import GuestRight, guests_may
from server.http.routes.contents import Asked, ContentsReading
from server.http.series_answer import BUCKETS, Buckets, Seconds, SeriesAnswer, json_answer

if TYPE_CHECKING:
    from mapper.io.contents.fields import TopicFields

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

Made = Literal["value", "derivative", "average"]
READING: dict[int | str, dict[str, Any]] = {
    202: {"model": ContentsReading, "description": "The recording is still being read."}
}


@dataclass(frozen=True, slots=True)
class TopicFieldsAnswer:
    """The numbers of a topic that can be plotted, by the paths of their fields; ``why`` there are none, else empty.

    ``computed`` says that they do not come from a topic, but are computed from the log's scans, its map or its pose
    graph. ``frames`` are the coordinate frames in its first message (``frame_id`` and ``child_frame_id``).
    """

    topic: str
    type: str
    fields: list[str]
    why: str
    frames: list[str]
    computed: bool = False


@dataclass(frozen=True, slots=True)
class FieldsAnswer:
    """The numbers of each topic that can be plotted."""

    topics: list[TopicFieldsAnswer]
    state: Literal["ready"] = "ready"


@router.get("/{session_id}/contents/fields", responses=READING)
@guests_may(GuestRight.LINKED_SESSION)
async def fields(response: Response, asked: Asked) -> FieldsAnswer | ContentsReading:
    """Return every number and every frame in the first message of each topic, and the series computed from the log.

    202 with ``progress`` while they are being read.
    """
    held = await asked.held()
    topics = [(topic.name, topic.type) for topic in held.contents.topics]
    library, owner = asked.library, asked.owner
    answer: Sequence[TopicFields] | float = (
        await library.fields(owner, held.recording.log_id, asked.visitor, topics, address=asked.address)
        if any(kind != CARMEN_LINE for _, kind in topics)
        else []
    )
    if isinstance(answer, float):
        response.status_code = 202
        return ContentsReading(round(answer, 3))
    ready = {series.topic: [_ready_name(column) for column in series.columns] for series in held.contents.series}
    named = {series.topic: series for series in answer}
    computed = [
        TopicFieldsAnswer(topic, "computed", list(names), "", [], computed=True)
        for topic, names in (await computed_fields(library, asked.sessions.get(asked.session_id), owner)).items()
    ]
    return FieldsAnswer(
        computed
        + [
            TopicFieldsAnswer(
                name,
                kind,
                list(named[name].fields) if name in named and named[name].fields else ready.get(name, []),
                named[name].why if name in named and name not in ready else "",
                list(named[name].frames) if name in named else [],
            )
            for name, kind in topics
        ]
    )


def _ready_name(column: Column) -> str:
    """Return the name of a number that is stored with the contents, in the form of a field's name."""
    return f"{column.plot} {column.label}"


@router.get("/{session_id}/contents/field", response_model=SeriesAnswer, responses=READING)
@guests_may(GuestRight.LINKED_SESSION)
async def field(
    asked: Asked,
    topic: Annotated[str, Query(max_length=400)],
    field: Annotated[str, Query(max_length=400, description="Its path in the message, as /contents/fields has it.")],
    made: Annotated[Made, Query(description="The value, its change per second, or its moving average.")] = "value",
    window: Annotated[float, Query(gt=0.0, le=86_400.0, description="Window of the moving average, seconds.")] = 1.0,
    start: Annotated[Seconds | None, Query(description="Seconds; from the beginning where left out.")] = None,
    end: Annotated[Seconds | None, Query(description="Seconds; to the end where left out.")] = None,
    buckets: Buckets = BUCKETS,
    evenly: Annotated[bool, Query(description="Every n-th sample instead of the extremes of each bucket.")] = False,
) -> Response:
    """Return one number of a topic's messages over time, or one that is computed from the log.

    202 with ``progress`` while the recording is being read, or the series computed.
    """

    async def answered(made_of: Series, origin_ns: int) -> Response:
        return await asked.in_turn(
            lambda: json_answer(
                SeriesAnswer.of(_made(made_of, made, window), origin_ns, start, end, buckets, evenly=evenly)
            ),
        )

    if topic in COMPUTED:
        session = asked.sessions.get(asked.session_id)
        computed = await computed_series(asked.library, session, asked.owner, topic)
        if isinstance(computed, float):
            return json_answer(ContentsReading(round(computed, 3)), 202)
        return await answered(_column(computed, field), plot_origin_ns(recording_of(session).log))
    held = await asked.held()
    series = _ready(held.contents, topic, field)
    if series is None:
        kind = next((topic_.type for topic_ in held.contents.topics if topic_.name == topic), None)
        if kind is None:
            raise MapperError("contents.no_topic", f"The recording has no topic {topic!r:.200}.")
        whole = await asked.library.field_series(
            asked.owner, held.recording.log_id, asked.visitor, topic, kind, address=asked.address
        )
        if isinstance(whole, float):
            return json_answer(ContentsReading(round(whole, 3)), 202)
        series = _column(whole, field)
    return await answered(series, held.origin_of(series))


def _ready(contents: Contents, topic: str, field: str) -> Series | None:
    """Return a number that is stored with the contents; None for any other one."""
    for series in contents.series:
        names = [_ready_name(column) for column in series.columns]
        if series.topic == topic and field in names:
            return _only(series, names.index(field))
    return None


def _column(series: Series, field: str) -> Series:
    names = [column.label for column in series.columns]
    if field not in names:
        raise MapperError("contents.no_field", f"Of {series.topic!r:.200} there is no number {field!r:.200}.")
    return _only(series, names.index(field))


def _only(series: Series, n: int) -> Series:
    return Series(
        series.topic,
        series.type,
        (series.columns[n],),
        series.stamps_ns,
        series.values[:, n : n + 1],
        recorded=series.recorded,
    )


def _made(series: Series, made: Made, window_s: float) -> Series:
    """Return the series derived from a series of one column."""
    if made == "value":
        return series
    column = series.columns[0]
    is_angle = column.unit == "rad"
    values = series.values[:, 0].astype(np.float64)
    if made == "derivative":
        values = derivative(series.stamps_ns, values, is_angle=is_angle)
        column = Column(column.label, unit_of_rate(column.unit), column.plot)
    else:
        values = moving_average(series.stamps_ns, values, window_s, is_angle=is_angle)
    return Series(series.topic, series.type, (column,), series.stamps_ns, values[:, None], recorded=series.recorded)
