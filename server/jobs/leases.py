"""Leases: among several services on one database, only one at a time does a job.

A lease is a row with its holder and an expiry time, which the holder extends while the job lasts. A service that is
killed or cut off no longer extends it, and another one takes the job over. The result of a job is written in one
transaction with the check that the lease is still held, so that two services never both write it. A database used by
one service needs no leases. All methods run on the event loop.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import structlog

from mapper.core.errors import MapperError
from server.storage import StorageError

WAIT_S = 1.0  #: interval of checking whether another service has done a job, or no longer holds its lease
WAITING_AT_ONCE = 20  #: number of jobs that are checked at this interval; more of them are checked less often
RENEWALS = 5  #: renewals of a lease during its validity

_log = structlog.get_logger(__name__)


class LeaseLostError(MapperError):
    """The lease was not renewed in time, so another service may do the job."""


class LeaseRows(Protocol):
    """The leases of one service, if several share them. All methods raise :class:`StorageError`."""

    async def take(self, name: str) -> bool:
        """Acquire a lease unless another service holds it; return whether it was acquired."""

    async def renew(self, name: str, fraction: float) -> bool:
        """Renew a lease, and store the completed share of its job; return False if it is no longer held."""

    def give_back(self, name: str) -> None:
        """Release a lease. If that fails, it expires."""

    async def finish(self, name: str, work: Callable[[Any], None]) -> None:
        """Run ``work`` and release the lease in one transaction. Raises :class:`LeaseLostError`, without changes."""

    async def fraction(self, name: str) -> float | None:
        """Return the completed share of a job from the holder of its lease, None if there is no holder."""


@dataclass(frozen=True, slots=True)
class Once:
    """A job that only one service does. This service first waits for ``turn``.

    ``is_open`` returns whether the job may have to be done as far as this service knows, ``is_due`` what the database
    says; ``fraction`` returns the completed share.
    """

    name: str
    turn: Callable[[], AbstractAsyncContextManager[None]]
    is_open: Callable[[], bool]
    is_due: Callable[[], Awaitable[bool]]
    fraction: Callable[[], float] = lambda: 0.0


@dataclass(frozen=True, slots=True)
class Lease:
    """A lease that this service holds; ``rows`` is None if the database is not shared."""

    name: str
    rows: LeaseRows | None

    async def finish(self, work: Callable[[Any], None]) -> None:
        """Run ``work`` on the connection of a transaction that also releases the lease. Only for a shared database.

        Raises :class:`LeaseLostError` (then nothing was done), and :class:`StorageError`.
        """
        assert self.rows is not None  # noqa: S101 - stated above
        await self.rows.finish(self.name, work)


class Leases:
    """The leases of one service, in ``rows``. None: no other service uses the database, and all leases are free.

    ``lease_s`` is the validity of a lease of ``rows``.
    """

    def __init__(self, rows: LeaseRows | None, lease_s: float) -> None:
        self._rows = rows
        self._lease_s = lease_s
        self._waiting = 0
        self.elsewhere: dict[str, float] = {}  #: completed shares of jobs of other services that are waited for here

    @property
    def is_shared(self) -> bool:
        """Whether other services may use the database."""
        return self._rows is not None

    async def done_once(self, job: Once, work: Callable[[Lease], Awaitable[None]], *, adopted: bool = False) -> None:
        """Do ``work`` here, or return when another service has done the job.

        An ``adopted`` job was requested from another service, which may start it first. Raises like :meth:`held`.
        """
        wait = adopted and self.is_shared
        while not wait or await self._free(job):
            try:
                async with job.turn(), self.held(job.name, job.fraction) as lease:
                    if lease is not None:
                        if not self.is_shared or await job.is_due():
                            await work(lease)
                        return
            except LeaseLostError:
                _log.warning("a job was taken over by another service", job=job.name)
            wait = True

    async def _free(self, job: Once) -> bool:
        """Wait until a job may be acquired, and return True; return False once it has been done."""
        assert self._rows is not None  # noqa: S101 - all leases are free otherwise
        self._waiting += 1
        try:
            while job.is_open():
                await asyncio.sleep(WAIT_S * max(1.0, self._waiting / WAITING_AT_ONCE))
                try:
                    done = await self._rows.fraction(job.name)
                except StorageError:  # the database is unavailable
                    continue
                if done is None and job.is_open():
                    return True
                self.elsewhere[job.name] = done or 0.0
            return False
        finally:
            self._waiting -= 1
            self.elsewhere.pop(job.name, None)

    @asynccontextmanager
    async def alone(self, name: str) -> AsyncIterator[None]:
        """Wait for a lease and hold it, which only one service at a time can. Raises like :meth:`held`."""
        while True:
            async with self.held(name) as lease:
                if lease is not None:
                    yield
                    return
            await asyncio.sleep(0.05)

    @asynccontextmanager
    async def held(self, name: str, fraction: Callable[[], float] = lambda: 0.0) -> AsyncIterator[Lease | None]:
        """Acquire a lease, renew it until the block ends, and release it; None if another service holds it.

        If the lease is lost, the block is cancelled and :class:`LeaseLostError` is raised. Raises
        :class:`StorageError`.
        """
        rows = self._rows
        if rows is None:
            yield Lease(name, None)
            return
        if not await rows.take(name):
            yield None
            return
        task = asyncio.current_task()
        assert task is not None  # noqa: S101 - for the type checker
        lost = asyncio.Event()
        renewing = asyncio.create_task(self._renew(rows, name, fraction, lost, task))
        try:
            yield Lease(name, rows)
        except asyncio.CancelledError:
            if not lost.is_set():
                raise
            task.uncancel()
            raise LeaseLostError("lease.lost", "Another service may do this job now.") from None
        finally:
            renewing.cancel()
            rows.give_back(name)

    async def _renew(
        self,
        rows: LeaseRows,
        name: str,
        fraction: Callable[[], float],
        lost: asyncio.Event,
        holder: asyncio.Task[object],
    ) -> None:
        """Renew a lease until this is cancelled; cancel its ``holder`` if it is lost."""
        renewed, is_held = time.monotonic(), True
        while is_held:
            await asyncio.sleep(self._lease_s / RENEWALS)
            asked = time.monotonic()
            try:
                async with asyncio.timeout(renewed + self._lease_s - asked):
                    is_held = await rows.renew(name, fraction())
                    renewed = asked
            except TimeoutError:
                is_held = False
            except StorageError:  # it is tried again while the lease is valid
                is_held = time.monotonic() < renewed + self._lease_s
        lost.set()
        holder.cancel()
