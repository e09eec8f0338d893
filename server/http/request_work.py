"""What a request computes: on a thread, one request at a time, for as long as its client waits."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from fastapi import Request

from server.http.routes.clients import client_address, to_its_end, while_connected
from server.work.fair_lock import FairLock

T = TypeVar("T")


async def in_turn(request: Request, work: FairLock, visitor: str, compute: Callable[[], T]) -> T:
    """Return what ``compute`` returns; turns are by address, then by visitor. Raises as :func:`while_connected`."""

    async def computed() -> T:
        async with work.of(visitor, client_address(request)):
            return await to_its_end(asyncio.to_thread(compute))

    return await while_connected(request, computed())
