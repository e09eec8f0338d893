"""Sessions that follow a job which adds a trajectory to their log."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from numpy.typing import NDArray

from mapper.core.errors import MapperError
from server.library.library import Library
from server.library.processing.localization import NAME as LOCALIZED
from server.library.processing.log_jobs import AnyLogJobs, LogJobs
from server.library.processing.slam import NAME as SLAM
from server.sessions import SessionRegistry
from server.sessions.commands import FollowPoses, PosesEnded, PosesSoFar, UpdateLog
from server.sessions.parts import Recording
from server.stream.protocol import ProtocolError

if TYPE_CHECKING:
    from server.library.processing.localization import LocalizeProgress
    from server.sessions import SessionHost

_tasks: set[asyncio.Task[None]] = set()  # of finished jobs, because asyncio itself keeps no reference


class Report(Protocol):
    """The poses (k, 3), ``T_map_base``, of the first k scans so far."""

    @property
    def fraction(self) -> float:
        """Progress of the job, from 0 to 1."""

    @property
    def stage(self) -> str:
        """Current stage of the job."""

    @property
    def poses(self) -> NDArray[Any]:
        """The poses."""


R = TypeVar("R", bound=Report)


def _follow(
    session: SessionHost,
    jobs: LogJobs[Any, R, Any, Any],
    log_id: str,
    name: str,
    shown: Callable[[R], LocalizeProgress | None] = lambda _: None,
) -> None:
    """Make a session show the map along the poses so far, as the trajectory ``name``.

    ``shown`` returns a report whose particles the session also shows.
    """
    session.enqueue(FollowPoses(name))

    def notify(report: R | None) -> None:
        # If reports come faster than the map is computed, only the newest counts; another one follows soon.
        if report is not None and not session.closed and not session.has_queued_commands:
            answer = shown(report)
            session.enqueue(PosesSoFar(report.poses, None if answer is None else answer.converged, answer))

    session.on_close.append(jobs.listen(session.owner, log_id, notify))


def join_jobs(library: Library, sessions: SessionRegistry, session: SessionHost) -> None:
    """Make a new session follow the running jobs on its log, whose owner had another session when they began.

    That session may have been lost with its service.
    """
    recording = session.model.find(Recording)
    if recording is None or session.link is not None:
        return
    owner, log_id = session.owner, recording.log_id

    with suppress(MapperError):  # the log was deleted in the meantime
        if library.slam.is_under_way(owner, log_id):
            follow_slam(session, library, log_id)
            tell_at_end(library, sessions, library.slam, owner, log_id)
        if library.localization.is_under_way(owner, log_id):
            follow_localization(session, library, log_id)
            tell_at_end(library, sessions, library.localization, owner, log_id)


def follow_slam(session: SessionHost, library: Library, log_id: str) -> None:
    """Make a session show the map along the poses that SLAM of its log has computed so far."""
    _follow(session, library.slam, log_id, SLAM)


def follow_localization(session: SessionHost, library: Library, log_id: str) -> None:
    """Make a session show the map along the poses of its log's localization so far, and the particles."""
    _follow(session, library.localization, log_id, LOCALIZED, lambda report: report)


def tell_at_end(library: Library, sessions: SessionRegistry, jobs: AnyLogJobs, owner: str, log_id: str) -> None:
    """Add the finished job's trajectory to the owner's sessions on the log. Sessions that follow the job show it."""

    async def tell() -> None:
        result = jobs.result(owner, log_id)
        trajectory = None if result is None else result.trajectory
        if trajectory is None:  # first return to the previous poses, because those of the job are not in the library
            end(None)
        await update_sessions(library, sessions, owner, log_id)
        if trajectory is not None:
            end(trajectory)

    def end(trajectory: str | None) -> None:
        for session in sessions.all():
            recording = session.model.find(Recording)
            if recording is not None and recording.log_id == log_id and session.owner == owner:
                session.enqueue(PosesEnded(trajectory))

    async def quietly() -> None:
        try:
            await tell()
        except (MapperError, ProtocolError):  # the log was deleted meanwhile, or a session accepts no more commands
            return

    def notify(report: object) -> None:
        if report is None:
            task = asyncio.create_task(quietly())
            _tasks.add(task)
            task.add_done_callback(_tasks.discard)

    jobs.listen(owner, log_id, notify)


async def update_sessions(library: Library, sessions: SessionRegistry, owner: str, log_id: str) -> None:
    """Update the trajectories in the open sessions of ``owner`` on a log."""
    for session in sessions.all():
        recording = session.model.find(Recording)
        if recording is None or recording.log_id != log_id or session.owner != owner or session.link is not None:
            continue
        view = recording.view()
        log = await library.load(owner, log_id, view.topic, view.planar_cut)
        with suppress(ProtocolError):  # too many commands; the next session on the log has them
            session.enqueue(UpdateLog(log))
