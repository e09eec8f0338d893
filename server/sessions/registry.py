"""All live sessions of the service, within budgets of number, visitor, memory and idle time.

The registry does not depend on the kind of session: it creates models from plans, and reads their memory use.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import structlog

from mapper.core.errors import LimitError, MapperError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.sensors.scan import ScanLog
from server.library.library import Library
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making, UnderWay
from server.sessions.prefetching import CheckpointPrefetching
from server.stream.traffic import Traffic
from server.work.memory import give_back
from server.work.scheduler import JobOwner, Scheduler

if TYPE_CHECKING:
    from server.sessions.host import SessionHost
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Use:
    """Numbers of sessions, cells of their grids, and bytes of their logs; ``guests`` is the part that guests use."""

    sessions: int = 0
    guests: int = 0
    cells: int = 0
    guests_cells: int = 0
    log_bytes: int = 0


class OthersUse(Protocol):
    """Total use by the sessions of the service's other workers."""

    def others(self) -> Use:
        """Return the total."""

    def state(self, own: Use) -> None:
        """Publish what the sessions of this worker use."""


REAP_EVERY_S = 5.0
STATE_EVERY_S = 1.0  #: interval of publishing the use to the other workers
ENDING_S = 1.0  #: longest wait for the last computation of a session that ends
THREADS_OF_SESSION = 4  #: at most: its tick, its second map, and HTTP requests

_log = structlog.get_logger(__name__)


def _host_class() -> type[SessionHost]:
    from server.sessions.host import SessionHost  # noqa: PLC0415 - the streams: imported with the first session

    return SessionHost


class SessionBudgetError(MapperError):
    """There is currently no room for another session."""


class SessionNotFoundError(MapperError):
    """There is no session with that id; it may have ended."""


class RegistrySettings(Protocol):
    """The part of :class:`server.settings.Settings` that the registry uses."""

    max_sessions: int
    max_sessions_per_visitor: int
    session_idle_s: float
    max_cells: int
    max_total_cells: int
    max_log_bytes: int
    threads: int
    max_story_s: float


class SessionRegistry:
    """Registry that creates, finds and ends sessions. Used from the event loop only.

    Call :meth:`start` before use and :meth:`shutdown` afterwards.
    """

    def __init__(
        self,
        settings: RegistrySettings,
        clock: Callable[[], float] = time.monotonic,
        remake_seconds: Callable[[float], None] = lambda _: None,
        traffic: Traffic | None = None,
        elsewhere: OthersUse | None = None,
    ) -> None:
        """Create a registry. ``elsewhere`` is the other workers' use of the same budgets; None without workers."""
        self._settings = settings
        self._elsewhere = elsewhere
        self._clock = clock
        self._remake_seconds = remake_seconds
        self._traffic = traffic or Traffic()
        self._sessions: dict[str, SessionHost] = {}
        self._making: list[tuple[str, str | None]] = []  #: owner and link of sessions being created, which count
        self._tasks: list[asyncio.Task[None]] = []
        self._ending: set[asyncio.Task[None]] = set()  #: sessions that have ended and may still be computing
        self._have_ended = False  #: whether sessions have ended whose memory was not freed yet
        #: There are more threads than run at one time, because a thread whose time slice is over waits for the
        #: scheduler.
        self.pool = ThreadPoolExecutor(THREADS_OF_SESSION * settings.max_sessions, thread_name_prefix="session")
        self._scheduler = Scheduler(settings.threads)
        self.under_way = UnderWay()

    async def start(self) -> None:
        """Start the tasks that end idle sessions and prefetch checkpoints."""
        self.loop = asyncio.get_running_loop()
        preparing = CheckpointPrefetching(
            self.all, lambda session: self._limits(None, guest=True).max_cells >= session.cells
        )
        self._tasks = [
            asyncio.create_task(self._reap(), name="session reaper"),
            asyncio.create_task(preparing.run(), name="seeks prepared"),
        ]
        if self._elsewhere is not None:
            self._tasks.append(asyncio.create_task(self._keep_stating(), name="use of the budgets"))

    async def shutdown(self) -> None:
        """End all sessions."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self.under_way.end()
        # Concurrent, because closing a session waits until its computation is scheduled.
        await asyncio.gather(*(self._end(session) for session in self.all()))
        await asyncio.gather(*self._ending)
        await asyncio.to_thread(self.pool.shutdown, cancel_futures=True)

    def __len__(self) -> int:
        return len(self._sessions)

    def all(self) -> list[SessionHost]:
        """Return the live sessions."""
        return list(self._sessions.values())

    def get(self, session_id: str) -> SessionHost:
        """Return a session. Raises :class:`SessionNotFoundError`."""
        session = self._sessions.get(session_id)
        if session is None:
            raise SessionNotFoundError("session.unknown", "There is no such session; it may have ended.")
        return session

    async def create(
        self,
        kind: Kind,
        request: SessionRequest,
        visitor: str,
        library: Library,
        *,
        address: str = "",
        place: str = "",
    ) -> SessionHost:
        """Create the session that a visitor requested. Raises like the kind's plan and :meth:`begin`."""
        with self.under_way.making(visitor, request.name) as making:
            plan = await kind.plan(request, Resources(visitor, library, self._settings.max_story_s, making))
            return await self._begin(plan, visitor, making, address=address, place=place)

    async def begin(
        self,
        plan: Plan,
        owner: str,
        *,
        link: str | None = None,
        address: str = "",
        place: str = "",
        places: int | None = None,
    ) -> SessionHost:
        """Start a session for a visitor. ``link`` is the link that a guest followed.

        ``places`` is the maximum number of sessions of that link; None: the same as for one visitor. ``address`` is the
        visitor's network address, ``place`` the part of the id by which a reverse proxy finds this service. While the
        model is being created, :attr:`under_way` has its progress; cancelling ends it. Raises
        :class:`SessionBudgetError`, and like the plan's ``make``.
        """
        with self.under_way.making(owner, plan.name) as making:
            return await self._begin(plan, owner, making, link=link, address=address, place=place, places=places)

    async def _begin(
        self,
        plan: Plan,
        owner: str,
        making: Making,
        *,
        link: str | None = None,
        address: str = "",
        place: str = "",
        places: int | None = None,
    ) -> SessionHost:
        host = (await asyncio.to_thread(_host_class))(
            job_owner=JobOwner(owner, address),
            pool=self.pool,
            limits=self.limits,
            scheduler=self._scheduler,
            link=link,
            traffic=self._traffic,
            remake_seconds=self._remake_seconds,
            place=place,
        )
        async with self._reserved(owner, link, places):
            for log in plan.logs:
                await self.free_bytes(log, owner, guest=link is not None)

            def make() -> None:
                model = plan.make(host, making)
                model.playback.playing = model.playback.playing and plan.playing
                host.prepare(model)

            await self._scheduler.run(self.pool, host.job_owner, make, interactive=plan.interactive)
            host.start()
            self._sessions[host.id] = host
        self._state_use()
        _log.info("session began", kind=host.model.kind, cells=host.cells, sessions=len(self._sessions))
        return host

    async def close(self, session_id: str) -> None:
        """End a session. Raises :class:`SessionNotFoundError`."""
        await self._end(self.get(session_id))

    async def end_linked(self, link: str) -> None:
        """End the sessions of all guests of a link."""
        for session in [session for session in self.all() if session.link == link]:
            await self._end(session)

    async def _end(self, session: SessionHost) -> None:
        """End a session. Its computation ends at its next check, unless a kernel is being compiled."""
        self._sessions.pop(session.id, None)
        ending = asyncio.create_task(self._close(session), name="session ending")
        self._ending.add(ending)
        ending.add_done_callback(self._ending.discard)
        await asyncio.wait((ending,), timeout=ENDING_S)

    async def _close(self, session: SessionHost) -> None:
        await session.close()
        self._have_ended = True
        self._state_use()
        _log.info("session ended", kind=session.model.kind, sessions=len(self._sessions))

    def limits(self, session: SessionHost | None) -> Limits:
        """Return the limits of the grid of ``session`` (None: a new one), given the cells of the other sessions."""
        owner = None if session is None else session.owner
        return self._limits(session, guest=session is not None and session.link is not None, owner=owner)

    def _limits(self, session: SessionHost | None, *, guest: bool, owner: str | None = None) -> Limits:
        others, elsewhere = [s for s in self._sessions.copy().values() if s is not session], self._others()
        room = self._settings.max_total_cells - elsewhere.cells - sum(s.cells for s in others)
        if guest:  # all guests together have at most half of the cells
            used = elsewhere.guests_cells + sum(s.cells for s in others if s.link is not None)
            room = min(room, self._settings.max_total_cells // 2 - used)
        if owner is not None:  # one visitor has at most half, but at least one grid of the largest size
            share = max(self._settings.max_total_cells // 2, self._settings.max_cells)
            room = min(room, share - sum(s.cells for s in others if s.owner == owner))
        return replace(DEFAULT_LIMITS, max_cells=max(min(self._settings.max_cells, room), 1))

    def _others(self) -> Use:
        """Return the use by the other workers."""
        return Use() if self._elsewhere is None else self._elsewhere.others()

    def _state_use(self) -> None:
        if self._elsewhere is None:
            return
        live, guests = self.all(), self._guests()
        logs = {id(log.ranges): log.ranges.nbytes for session in live for log in session.model.footprint.logs}
        cells, guests_cells = sum(s.cells for s in live), sum(s.cells for s in guests)
        self._elsewhere.state(Use(len(live), len(guests), cells, guests_cells, sum(logs.values())))

    async def _keep_stating(self) -> None:
        while True:  # grids grow
            self._state_use()
            await asyncio.sleep(STATE_EVERY_S)

    # -- budgets ---------------------------------------------------------------------------------------------------

    @asynccontextmanager
    async def _reserved(self, owner: str, link: str | None = None, places: int | None = None) -> AsyncIterator[None]:
        """Reserve room while a session is created on a worker thread; end an idle session if there is none.

        Guests of links only end sessions of guests, and have at most half of all sessions.
        """
        place = (owner, link)
        self._making.append(place)
        try:
            mine = [s for s in self._sessions.values() if s.owner == owner]
            if len(mine) + sum(owner_ == owner for owner_, _ in self._making) > self._settings.max_sessions_per_visitor:
                message = f"You have {len(mine)} sessions open, the most for one visitor: close one first."
                await self._evict(mine, "session.too_many", message)
            if link is not None:
                await self._make_room_for_guest(link, places or self._settings.max_sessions_per_visitor)
            here = len(self._sessions) + len(self._making)
            if here + self._others().sessions > self._settings.max_sessions:
                message = "The service has no room for another session now."
                idle_guests = [s for s in self._guests() if not s.watched]
                await self._evict(idle_guests if idle_guests or link else self.all(), "session.full", message)
            await self._free_cells(guest=link is not None, owner=owner)
            if self._limits(None, guest=link is not None, owner=owner).max_cells == 1:
                message = (
                    "The open maps use all cells of the service, or all that one visitor may have: close one first."
                )
                raise SessionBudgetError("session.memory", message)
            yield
        finally:
            self._making.remove(place)

    def _guests(self) -> list[SessionHost]:
        return [session for session in self._sessions.values() if session.link is not None]

    async def _make_room_for_guest(self, link: str, places: int) -> None:
        """Make room for one more session of a link, which may have ``places`` sessions."""
        same = [s for s in self._guests() if s.link == link]
        if len(same) + sum(link_ == link for _, link_ in self._making) > places:
            message = "This link is in use by as many people as it allows."
            await self._evict(same, "link.crowded", message)
        guests = self._guests()
        most = max(1, self._settings.max_sessions // 2)
        here = len(guests) + sum(session is not None for _, session in self._making)
        if here + self._others().guests > most:
            await self._evict(guests, "session.full", "The service has no room for another guest now.")

    async def _free_cells(self, *, guest: bool, owner: str) -> None:
        """End idle sessions until there is room for a grid of the largest size.

        The visitor's own sessions are ended first, because ending others makes no room if the visitor's share is used
        up.
        """
        for whose in (owner, None):
            while self._limits(None, guest=guest, owner=whose).max_cells < self._settings.max_cells:
                among = self._guests() if guest else self.all()
                idle = [s for s in among if not s.watched and whose in (s.owner, None)]
                if not idle:
                    break
                await self._end(min(idle, key=lambda s: s.unwatched_since))

    async def free_bytes(self, log: ScanLog, owner: str, *, guest: bool = False) -> None:
        """End idle log sessions, for a ``guest`` only those of guests, until there is room for ``log``.

        The logs of one visitor may use at most half of the memory, but at least one log of the largest size. Raises
        :class:`SessionBudgetError` if there is currently no room, and :class:`LimitError` if there never is.
        """
        room = self._settings.max_log_bytes - log.ranges.nbytes
        if room < 0:
            raise LimitError("session.log_bytes", "This log needs more memory than the server has for logs.")
        share = max(self._settings.max_log_bytes // 2 - log.ranges.nbytes, 0)
        own = "Your open logs use all the memory that one visitor may have: close one first."
        await self._free_bytes(log, share, own, guest=guest, owner=owner)
        all_open = "The open logs use all the memory for logs now."
        await self._free_bytes(log, room - self._others().log_bytes, all_open, guest=guest)

    async def _free_bytes(
        self, log: ScanLog, room: int, message: str, *, guest: bool, owner: str | None = None
    ) -> None:
        """End sessions until logs other than ``log`` (of ``owner``, if given) use at most ``room`` bytes."""
        while True:
            logs = [s for s in self._sessions.values() if s.model.footprint.logs and owner in (s.owner, None)]
            # Sessions of one log share its data.
            held = {
                s: {
                    id(log_.ranges): log_.ranges.nbytes
                    for log_ in s.model.footprint.logs
                    if log_.ranges is not log.ranges
                }
                for s in logs
            }
            if sum({key: size for sizes in held.values() for key, size in sizes.items()}.values()) <= room:
                return
            needed = {key for s, sizes in held.items() if s.watched for key in sizes}
            # Ending a session frees only logs that no watched session shares.
            idle = [s for s, sizes in held.items() if sizes.keys() - needed and (s.link is not None or not guest)]
            await self._evict(idle, "session.memory", message)

    async def _evict(self, sessions: Sequence[SessionHost], code: str, message: str) -> None:
        """End the session that has been idle for the longest time."""
        idle = [s for s in sessions if not s.watched]
        if not idle:
            raise SessionBudgetError(code, message)
        await self._end(min(idle, key=lambda s: s.unwatched_since))

    async def _reap(self) -> None:
        while True:
            await asyncio.sleep(REAP_EVERY_S)
            await self.reap()
            if self._have_ended:  # models contain reference cycles, which only the garbage collector frees
                self._have_ended = False
                await asyncio.to_thread(give_back, is_idle=not self.all())

    async def reap(self) -> None:
        """End the sessions that have been idle for too long."""
        oldest = self._clock() - self._settings.session_idle_s
        for session in self.all():
            if not session.watched and session.unwatched_since <= oldest:
                await self._end(session)
