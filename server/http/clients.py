"""The client of a request: its address, and whether it is still connected."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from fastapi import Request
from starlette.requests import HTTPConnection

from mapper.core.errors import MapperError
from server.http.services import services_of
from server.network_address import network_of
from server.work.fair_lock import FairLock
from server.workers.places import PLACE_HEADER

_PLACE = re.compile(r"[0-9a-z]{1,32}")

T = TypeVar("T")


def client_address(request: HTTPConnection) -> str:
    """Return the client's address, for IPv6 its /64 network; empty if unknown."""
    return "" if request.client is None else network_of(request.client.host)


def chosen_place(request: HTTPConnection) -> str:
    """Return the key by which a reverse proxy finds this service or worker; empty if there is only one.

    Ids of sessions that the request creates start with it. A reverse proxy in front of several services sends it
    (``deploy/haproxy.cfg``).
    """
    place = request.headers.get(PLACE_HEADER, "")
    if _PLACE.fullmatch(place):
        return place
    worker = services_of(request.app).worker
    return "" if worker is None else str(worker.number)


async def while_connected(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """Return the result of ``work``, or cancel it if the client disconnects. The body must have been read before.

    Raises like ``work``, and :class:`MapperError` if the client has disconnected.
    """
    working, gone = asyncio.ensure_future(work), asyncio.ensure_future(_gone(request))
    try:
        await asyncio.wait((working, gone), return_when=asyncio.FIRST_COMPLETED)
        if working.done():
            return working.result()
        raise MapperError("request.gone", "The client disconnected before the answer.")
    finally:
        for task in (working, gone):
            task.cancel()
        await asyncio.gather(working, gone, return_exceptions=True)


async def to_its_end(work: Coroutine[Any, Any, T]) -> T:
    """Return the result of ``work``, which runs on an uninterruptible thread; when cancelled, wait for its end."""
    working = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(working)
    finally:
        await asyncio.wait([working])


async def _gone(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass


async def in_turn(request: Request, work: FairLock, visitor: str, compute: Callable[[], T]) -> T:
    """Return the result of ``compute``, run on a thread. Turns rotate by address, then by visitor.

    Raises like :func:`while_connected`.
    """

    async def computed() -> T:
        async with work.of(visitor, client_address(request)):
            return await to_its_end(asyncio.to_thread(compute))

    return await while_connected(request, computed())
