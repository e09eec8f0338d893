"""Leases: of several services on one database, one at a time does a job.

A lease is a row with its holder and a time, which the holder moves on while the job lasts. A service that is killed or
cut off moves it no more, and another one takes the job. What came of a job is written in one transaction with the check
that the lease is still held: two services never both write it. A database that one service has for itself needs none.
All methods run on the event loop.
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

WAIT_S = 1.0  #: seconds between two checks whether another service has done a job, or no longer holds its lease
WAITING_AT_ONCE = 20  #: jobs that are checked so often; more of them are checked less often
RENEWALS = 5  #: of a lease in the time for which it is valid

_log = structlog.get_logger(__name__)


class LeaseLostError(MapperError):
    """The lease was not renewed in time: another service may do the job."""


class LeaseRows(Protocol):
    """The leases that one service holds, where several services share them. All methods raise :class:`StorageError`."""

    async def take(self, name: str) -> bool:
        """Take a lease unless another service holds it; return whether it was taken."""

    async def renew(self, name: str, fraction: float) -> bool:
        """Renew a lease, and state how much of its job is done; return False where it is not held any more."""

    def give_back(self, name: str) -> None:
        """End a lease; what fails ends by itself."""

    async def finish(self, name: str, work: Callable[[Any], None]) -> None:
        """Run ``work`` and end the lease in one transaction. Raises :class:`LeaseLostError`; then nothing was done."""

    async def fraction(self, name: str) -> float | None:
        """Return how much of a job the holder of its lease has done, None where there is no holder."""


@dataclass(frozen=True, slots=True)
class Once:
    """A job that one service does: ``turn`` is waited for here first.

    ``is_open`` says whether it may have to be done as far as this service knows, ``is_due`` what the database says;
    ``fraction`` returns how much of it is done.
    """

    name: str
    turn: Callable[[], AbstractAsyncContextManager[None]]
    is_open: Callable[[], bool]
    is_due: Callable[[], Awaitable[bool]]
    fraction: Callable[[], float] = lambda: 0.0


@dataclass(frozen=True, slots=True)
class Lease:
    """A lease that this service holds; ``rows`` is None where no other service could."""

    name: str
    rows: LeaseRows | None

    async def finish(self, work: Callable[[Any], None]) -> None:
        """Run ``work`` on the connection of a transaction, and end the lease with it. Only of a shared database.

        Raises :class:`LeaseLostError`, then nothing was done, and :class:`StorageError`.
        """
        assert self.rows is not None  # noqa: S101 - stated above
        await self.rows.finish(self.name, work)


class Leases:
    """The leases of one service, in ``rows``; None: no other service uses the database, and all of them are free.

    ``lease_s`` is the time for which a lease of ``rows`` is valid.
    """

    def __init__(self, rows: LeaseRows | None, lease_s: float) -> None:
        self._rows = rows
        self._lease_s = lease_s
        self._waiting = 0
        self.elsewhere: dict[str, float] = {}  #: how much of each job is done that is waited for here

    @property
    def is_shared(self) -> bool:
        """Whether other services may use the database."""
        return self._rows is not None

    async def done_once(self, job: Once, work: Callable[[Lease], Awaitable[None]], *, adopted: bool = False) -> None:
        """Do ``work`` here, or return when another service has done the job.

        One that was ``adopted`` was asked of another service, which may begin with it first. Raises as :meth:`held`.
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
        """Wait until a job may be taken, and return True; False once it has been done."""
        assert self._rows is not None  # noqa: S101 - all leases are free otherwise
        self._waiting += 1
        try:
            while job.is_open():
                await asyncio.sleep(WAIT_S * max(1.0, self._waiting / WAITING_AT_ONCE))
                try:
                    done = await self._rows.fraction(job.name)
                except StorageError:  # the database is away
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
        """Wait for a lease and hold it: among all services one at a time. Raises as :meth:`held`."""
        while True:
            async with self.held(name) as lease:
                if lease is not None:
                    yield
                    return
            await asyncio.sleep(0.05)

    @asynccontextmanager
    async def held(self, name: str, fraction: Callable[[], float] = lambda: 0.0) -> AsyncIterator[Lease | None]:
        """Take a lease, renew it until the block ends, and give it back; None where another service holds it.

        The block is cancelled when the lease is lost, and :class:`LeaseLostError` raised. Raises
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
        """Renew a lease until this is cancelled; cancel its ``holder`` when it is lost."""
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
            except StorageError:  # tried again while the lease is valid
                is_held = time.monotonic() < renewed + self._lease_s
        lost.set()
        holder.cancel()
