"""``/api/sessions/{id}/contents``: the contents of a log's recording besides the scans of its map."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response

from mapper.core.errors import ConfigError, MapperError, ReadError
from mapper.core.se3 import to_euler
from mapper.io.contents.camera_pose import sight_of
from mapper.io.contents.frame_graph import chain_of, faults, parents_of, tree_for, trees_of
from mapper.io.contents.model import PICTURED, Contents, FrameEdge, Series, TopicContents
from mapper.sensors.joint_log import JointLog
from mapper.sensors.planar.options import is_cut
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import poses_at
from server.http.clients import client_address, in_turn, while_connected
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.series_answer import BUCKETS, Buckets, Seconds, SeriesAnswer, json_answer
from server.http.services import Logs, RequestWork, Sessions, Visitor
from server.http.session_access import log_owner, part_of_log
from server.library.library import Library
from server.sessions import SessionRegistry
from server.sessions.parts import Recording
from server.work.fair_lock import FairLock

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

LAST_NS = 1 << 62  #: SQLite's integers end at twice as much


class NotInspectedError(MapperError):
    """The contents of the recording are still being read."""


@dataclass(frozen=True, slots=True)
class HeldContents:
    """The contents of a session's recording, and its times on the page's time line."""

    recording: Recording
    contents: Contents

    @property
    def origin_ns(self) -> int:
        """The time that is 0 s on the page's time line."""
        return _origin_ns(self.recording.log)

    @property
    def recorded_ahead_ns(self) -> int:
        """Time from the stamp of the log's first scan to its recording, ns, including the difference of the clocks."""
        log = self.recording.log
        name = (log.parts[0] if isinstance(log, JointLog) else log).topic.partition("#")[0]
        firsts = [topic.first_ns for topic in self.contents.topics if topic.name == name and topic.first_ns]
        return firsts[0] - self.origin_ns if firsts else 0

    def origin_of(self, series: Series) -> int:
        """Return the stamp of a series that corresponds to 0 s."""
        return self.origin_ns + (self.recorded_ahead_ns if series.recorded else 0)

    def recorded_ns(self, seconds: float) -> int:
        """Return the recording time for a moment, which is later than the stamp of the scan at that moment."""
        return min(max(self.origin_ns + self.recorded_ahead_ns + round(seconds * 1e9), 0), LAST_NS)

    def seconds(self, stamp_ns: int) -> float:
        """Return the seconds of a stamp."""
        return round((stamp_ns - self.origin_ns) * 1e-9, 6)


def _origin_ns(log: ScanLog) -> int:
    return int(log.stamps_ns.min()) if log.n_scans else 0


@dataclass(frozen=True, slots=True)
class ContentsRequest:
    """A request for something of the recording of a session."""

    request: Request
    sessions: SessionRegistry
    library: Library
    visitor: str
    work: FairLock
    session_id: str

    @property
    def recording(self) -> Recording:
        """The recording. Raises :class:`MapperError` for a session of another kind, or none."""
        message = "Only a recording has contents to list, not a live world."
        return part_of_log(self.sessions.get(self.session_id), Recording, message)

    @property
    def owner(self) -> str:
        """The owner of the session's log; for a guest, the owner of the link."""
        return log_owner(self.sessions.get(self.session_id), self.library)

    @property
    def address(self) -> str:
        """The address that the request came from."""
        return client_address(self.request)

    async def contents(self) -> Contents | float:
        """Return the contents of the recording, or the progress of reading them, 0 to 1."""
        log_id = self.recording.log_id
        return await self.library.contents(self.owner, log_id, self.visitor, address=self.address)

    async def held(self) -> HeldContents:
        """Return the contents of the recording, if they are known. Raises :class:`NotInspectedError`."""
        recording, contents = self.recording, await self.contents()
        if isinstance(contents, float):
            message = "The contents of the recording are still being read; /contents reports the progress."
            raise NotInspectedError("contents.not_yet", message)
        return HeldContents(recording, contents)

    async def in_turn(self, answer: Callable[[], Response]) -> Response:
        """Return an answer computed off the event loop, because a series may have millions of samples."""
        return await in_turn(self.request, self.work, self.visitor, answer)


async def _contents_request(
    request: Request, sessions: Sessions, library: Logs, visitor: Visitor, work: RequestWork, session_id: str
) -> ContentsRequest:
    return ContentsRequest(request, sessions, library, visitor, work, session_id)


Asked = Annotated[ContentsRequest, Depends(_contents_request)]


@dataclass(frozen=True, slots=True)
class ContentsReading:
    """The contents of the recording are still being read: ``progress`` from 0 to 1."""

    progress: float
    state: Literal["reading"] = "reading"


@dataclass(frozen=True, slots=True)
class TopicAnswer:
    """A topic of the recording. Times are seconds since the log's first scan, null for topics without times.

    They are recording times, minus the delay from the stamp of that scan to its recording. ``mapped`` says whether the
    map uses the topic, null if no map can be made from it; ``cut`` whether it has clouds or images from which scans can
    be cut.
    """

    name: str
    type: str
    messages: int
    bytes: int
    rate_hz: float | None
    first_s: float | None
    last_s: float | None
    mapped: bool | None
    cut: bool


@dataclass(frozen=True, slots=True)
class PlottedTopic:
    """A topic with numbers for plots."""

    topic: str
    type: str
    samples: int
    plots: list[str]


@dataclass(frozen=True, slots=True)
class ContentsAnswer:
    """The contents of the recording; ``pictures`` are topics with images or clouds, ``frames`` a number of frames."""

    topics: list[TopicAnswer]
    series: list[PlottedTopic]
    frames: int
    pictures: list[str]
    notes: list[str]
    state: Literal["ready"] = "ready"


@router.get(
    "/{session_id}/contents",
    responses={202: {"model": ContentsReading, "description": "The recording is still being gone through."}},
)
@guests_may(GuestRight.LINKED_SESSION)
async def contents(response: Response, asked: Asked) -> ContentsAnswer | ContentsReading:
    """Return every topic of the recording, and which of them can be plotted.

    The first request starts reading them, which may take as long as reading the log. Until then the answer is 202 with
    ``progress`` from 0 to 1, and each request keeps the reading alive. Times are seconds since the log's first scan.
    """
    recording, contents = asked.recording, await asked.contents()
    if isinstance(contents, float):
        response.status_code = 202
        return ContentsReading(round(contents, 3))
    held = HeldContents(recording, contents)
    ahead_ns = held.recorded_ahead_ns
    sensors = {topic.name: topic.chosen for topic in recording.log.topics if topic.beams is not None}
    return ContentsAnswer(
        topics=[_topic(topic, held, ahead_ns, sensors.get(topic.name)) for topic in contents.topics],
        series=[
            PlottedTopic(
                topic=series.topic,
                type=series.type,
                samples=len(series.stamps_ns),
                plots=list(dict.fromkeys(column.plot for column in series.columns)),
            )
            for series in contents.series
        ],
        frames=len(_frames_of(contents.edges)),
        pictures=[topic.name for topic in contents.topics if topic.type in PICTURED],
        notes=list(contents.notes),
    )


@router.delete("/{session_id}/contents", status_code=204)
@guests_may(GuestRight.LINKED_SESSION)
async def stop(asked: Asked) -> None:
    """Stop reading the contents of the recording, if this visitor began it. The next request starts again."""
    asked.library.stop_inspecting(asked.owner, asked.recording.log_id, asked.visitor)


def _topic(topic: TopicContents, held: HeldContents, ahead_ns: int, is_chosen: bool | None) -> TopicAnswer:
    has_times = topic.first_ns > 0
    return TopicAnswer(
        name=topic.name,
        type=topic.type,
        messages=topic.messages,
        bytes=topic.bytes,
        rate_hz=topic.rate_hz,
        first_s=held.seconds(topic.first_ns - ahead_ns) if has_times else None,
        last_s=held.seconds(topic.last_ns - ahead_ns) if has_times else None,
        mapped=is_chosen,
        cut=is_cut(topic.type),
    )


@router.get("/{session_id}/contents/series", response_model=SeriesAnswer)
@guests_may(GuestRight.LINKED_SESSION)
async def series(
    asked: Asked,
    topic: Annotated[str, Query(max_length=400)],
    start: Annotated[Seconds | None, Query(description="Seconds; from the beginning where left out.")] = None,
    end: Annotated[Seconds | None, Query(description="Seconds; to the end where left out.")] = None,
    buckets: Buckets = BUCKETS,
) -> Response:
    """Return the numbers of one topic's messages over time, as extreme values, at most two rows per bucket."""
    held = await asked.held()
    series = next((series for series in held.contents.series if series.topic == topic), None)
    if series is None:
        raise MapperError("contents.no_series", f"The recording has no topic {topic!r:.200} that can be plotted.")

    return await asked.in_turn(
        lambda: json_answer(SeriesAnswer.of(series, held.origin_of(series), start, end, buckets))
    )


@router.get("/{session_id}/contents/picture", **file_answer("image/jpeg", "image/png"))
@guests_may(GuestRight.LINKED_SESSION)
async def picture(
    asked: Asked,
    topic: Annotated[str, Query(max_length=400)],
    at: Annotated[Seconds, Query(description="Seconds since the log's first scan.")] = 0.0,
) -> Response:
    """Return the latest image of a topic at a moment as JPEG, or its latest point cloud from above as PNG.

    The header ``X-Picture-Seconds`` is its recording time, on the same clock as ``at``.
    """
    held = await asked.held()
    if not any(topic_.name == topic and topic_.type in PICTURED for topic_ in held.contents.topics):
        raise MapperError("contents.no_picture", f"The recording has no images or clouds on {topic!r:.200}.")
    ahead_ns = held.recorded_ahead_ns
    making = asked.library.picture(
        asked.owner, held.recording.log_id, asked.visitor, topic, held.recorded_ns(at), address=asked.address
    )
    moment_picture = await while_connected(asked.request, making)
    seconds = held.seconds(moment_picture.stamp_ns - ahead_ns)
    headers = {"X-Picture-Seconds": f"{seconds:.3f}", "Cache-Control": "private, max-age=60"}
    return Response(moment_picture.data, media_type=moment_picture.media_type, headers=headers)


@dataclass(frozen=True, slots=True)
class CameraAnswer:
    """The place of a point of the map's floor in a camera's image.

    ``u`` and ``v`` are fractions of the image's width and height from its upper left corner, 0 for a point outside.
    ``where`` is null if the recording lacks necessary data; ``why`` says which.
    """

    where: Literal["inside", "outside", "behind"] | None
    u: float
    v: float
    why: str = ""


@router.get("/{session_id}/contents/camera")
@guests_may(GuestRight.LINKED_SESSION)
async def camera(
    asked: Asked,
    topic: Annotated[str, Query(max_length=400)],
    x: Annotated[float, Query(allow_inf_nan=False, description="Metres in the map.")],
    y: Annotated[float, Query(allow_inf_nan=False, description="Metres in the map.")],
    at: Annotated[Seconds, Query(description="Seconds since the log's first scan.")] = 0.0,
) -> CameraAnswer:
    """Return where a point of the map is in an image of a topic at a moment, along the current trajectory."""
    held = await asked.held()
    log = held.recording.log
    trajectory = log.trajectories[held.recording.trajectory]
    order = np.argsort(log.stamps_ns, kind="stable")
    at_ns = held.origin_ns + round(at * 1e9)
    pose = poses_at(log.stamps_ns[order], trajectory.poses[order], np.array(at_ns))
    try:
        sight = sight_of(held.contents, topic, trajectory.child_frame_id, pose, (x, y, 0.0), at_ns)
        return CameraAnswer(*sight)
    except (ReadError, ConfigError) as error:
        return CameraAnswer(None, 0.0, 0.0, error.message)


@dataclass(frozen=True, slots=True)
class LineAnswer:
    """A line logged by a node, ``seconds`` from the log's first scan; ``level`` as in ROS 2, 10 to 50."""

    seconds: float
    level: int
    topic: str
    name: str
    text: str


@dataclass(frozen=True, slots=True)
class LinesAnswer:
    """The lines logged by nodes, ascending in time; ``left_out`` is the number beyond the limit."""

    lines: list[LineAnswer]
    left_out: int


@router.get("/{session_id}/contents/lines", response_model=LinesAnswer)
@guests_may(GuestRight.LINKED_SESSION)
async def lines(asked: Asked) -> Response:
    """Return the lines of /rosout and the state changes on /diagnostics."""
    held = await asked.held()
    return await asked.in_turn(lambda: json_answer(_lines(held)))


def _lines(held: HeldContents) -> LinesAnswer:
    ahead_ns = held.recorded_ahead_ns
    matching = [
        LineAnswer(
            held.seconds(line.stamp_ns - (ahead_ns if line.is_recorded else 0)),
            line.level,
            line.topic,
            line.name,
            line.text,
        )
        for line in held.contents.lines
    ]
    return LinesAnswer(sorted(matching, key=lambda line: line.seconds), held.contents.lines_left_out)


@dataclass(frozen=True, slots=True)
class MessageAnswer:
    """A message of a recording: topic, type, size, and the ``fields`` by name, as in ``ros2 topic echo``.

    ``seconds`` is its recording time from the log's first scan. ``stamp_ns`` is the same since 1970, as text, because
    JSON numbers are not exact enough. Arrays are cut after their first elements, with a text that gives the number of
    the omitted ones.
    """

    topic: str
    type: str
    seconds: float
    stamp_ns: str
    bytes: int
    fields: dict[str, Any]


@router.get("/{session_id}/contents/message")
@guests_may(GuestRight.LINKED_SESSION)
async def message(
    asked: Asked,
    topic: Annotated[str, Query(max_length=400)],
    at: Annotated[Seconds, Query(description="Seconds since the log's first scan.")] = 0.0,
) -> MessageAnswer:
    """Return the latest message on a topic at a moment, decoded by the definition in the recording."""
    held = await asked.held()
    if not any(topic_.name == topic for topic_ in held.contents.topics):
        raise MapperError("contents.no_topic", f"The recording has no topic {topic!r:.200}.")
    ahead_ns = held.recorded_ahead_ns
    making = asked.library.message(
        asked.owner, held.recording.log_id, asked.visitor, topic, held.recorded_ns(at), address=asked.address
    )
    raw = await while_connected(asked.request, making)
    seconds = held.seconds(raw.stamp_ns - ahead_ns)
    return MessageAnswer(topic, raw.type, seconds, str(raw.stamp_ns), raw.bytes, raw.tree)


@dataclass(frozen=True, slots=True)
class FrameEdgeAnswer:
    """The transforms between two frames; ``age_s`` is that of the latest at the moment, null before the first.

    ``offset`` x, y, z, metres, and ``angles`` roll, pitch, yaw, radians (REP 103), are the child's pose in the parent
    at the moment, interpolated between two transforms as in tf2. After the last transform they are the last one's,
    before the first null. ``publishers`` are nodes, if the recording names them: a ROS 1 bag, or an MCAP file converted
    from one. ``used`` is false for a second parent of the same frame, which is ignored.
    """

    topic: str
    parent: str
    child: str
    static: bool
    count: int
    rate_hz: float | None
    age_s: float | None
    offset: tuple[float, float, float] | None
    angles: tuple[float, float, float] | None
    publishers: list[str]
    used: bool


@dataclass(frozen=True, slots=True)
class FramesAnswer:
    """The transforms on the topic ``tf``, one of ``trees``, ``at`` seconds; ``faults`` are sentences.

    ``elsewhere`` are the frames of the other trees.
    """

    at: float
    tf: str
    trees: list[str]
    fixed: str
    sensor: str
    frames: list[str]
    elsewhere: list[str]
    edges: list[FrameEdgeAnswer]
    faults: list[str]


@router.get("/{session_id}/contents/frames")
@guests_may(GuestRight.LINKED_SESSION)
async def frames(
    asked: Asked,
    at: Annotated[Seconds, Query(description="Seconds since the log's first scan.")] = 0.0,
    fixed: Annotated[str | None, Query(max_length=200, description="The frame to which all should lead.")] = None,
    tf: Annotated[
        str | None, Query(max_length=400, description="The topic of the transforms; else the sensor's.")
    ] = None,
) -> FramesAnswer:
    """Return the transforms of the recording: the age of each at a moment, and gaps between frames.

    Robots of one recording may have the same frames, each on its own topics; these are the trees. The fixed frame is
    that of the session's trajectory unless ``fixed`` names another one. If the recording's transforms do not contain
    it, it is the root above the sensor's frame.
    """
    held = await asked.held()
    log = held.recording.log
    sensor = (log.parts[0] if isinstance(log, JointLog) else log).topic.partition("#")[0]
    trees = trees_of(held.contents.edges, sensor)
    if tf is not None and tf not in trees:
        raise MapperError("contents.no_tree", f"The recording has no transforms on {tf!r:.200}.")
    topic = tree_for(trees, sensor, log.frame_id) if tf is None else tf
    edges = trees.get(topic, [])
    at_ns = held.origin_ns + round(at * 1e9)
    names = sorted(_frames_of(edges))
    parents = parents_of(edges)
    if fixed is None:
        fixed = log.trajectories[held.recording.trajectory].frame_id
        fixed = fixed if fixed in names else chain_of(parents, log.frame_id)[-1]
    elif fixed not in names:
        raise MapperError("contents.no_frame", f"The recording's transforms have no frame {fixed!r:.200}.")
    return FramesAnswer(
        at=at,
        tf=topic,
        trees=list(trees),
        fixed=fixed,
        sensor=log.frame_id,
        frames=names,
        elsewhere=sorted(_frames_of(held.contents.edges) - set(names)),
        edges=[_edge(edge, at_ns, is_used=parents.get(edge.child) == edge.parent) for edge in edges],
        faults=faults(edges, [log.frame_id], fixed) if edges else [],
    )


def _frames_of(edges: Iterable[FrameEdge]) -> set[str]:
    return {name for edge in edges for name in (edge.parent, edge.child)}


def _edge(edge: FrameEdge, at_ns: int, *, is_used: bool) -> FrameEdgeAnswer:
    pose = edge.pose_at(at_ns)
    return FrameEdgeAnswer(
        topic=edge.topic,
        parent=edge.parent,
        child=edge.child,
        static=edge.is_static,
        count=len(edge.stamps_ns),
        rate_hz=edge.rate_hz,
        age_s=edge.age_s(at_ns),
        offset=None if pose is None else pose[:3],
        angles=None if pose is None else to_euler(*pose[3:]),
        publishers=list(edge.publishers),
        used=is_used,
    )


@router.get("/{session_id}/contents/frame_age", response_model=SeriesAnswer)
@guests_may(GuestRight.LINKED_SESSION)
async def frame_age(
    asked: Asked,
    tf: Annotated[str, Query(max_length=400, description="The topic of the transforms.")],
    parent: Annotated[str, Query(max_length=200)],
    child: Annotated[str, Query(max_length=200)],
    buckets: Buckets = BUCKETS,
) -> Response:
    """Return the age of a moving transform over the time of the log, seconds. It grows until the next transform."""
    held = await asked.held()
    key = (tf, parent, child)
    edge = next((edge for edge in held.contents.edges if (edge.topic, edge.parent, edge.child) == key), None)
    if edge is None or edge.is_static:
        raise MapperError("contents.no_edge", f"No transforms from {child!r} to {parent!r} move on {tf!r:.200}.")
    until_ns = int(held.recording.log.stamps_ns.max(initial=held.origin_ns))

    # No gaps, because the line over a pause of the transforms is the requested age.
    return await asked.in_turn(
        lambda: json_answer(
            replace(SeriesAnswer.of(edge.ages(until_ns), held.origin_ns, None, None, buckets), gaps=[])
        ),
    )
