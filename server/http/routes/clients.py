"""Who sent a request, and whether somebody still waits for its answer."""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Coroutine
from typing import Any, TypeVar

from fastapi import Request

from mapper.core.errors import MapperError

T = TypeVar("T")

IPV6_PREFIX = 64  #: bits that name one site: a host chooses the others itself, as often as it likes


def client_address(request: Request) -> str:
    """Return the address that a request came from, of IPv6 its network; empty where it is not known."""
    host = "" if request.client is None else request.client.host
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv6Address):
        if address.ipv4_mapped is not None:
            return str(address.ipv4_mapped)
        return str(ipaddress.ip_network((address, IPV6_PREFIX), strict=False))
    return str(address)


async def while_connected(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """Return what ``work`` returns, and cancel it when the client has gone. The request's body was read before.

    Raises as ``work`` does, and :class:`MapperError` for a client that has gone.
    """
    working, gone = asyncio.ensure_future(work), asyncio.ensure_future(_gone(request))
    try:
        await asyncio.wait((working, gone), return_when=asyncio.FIRST_COMPLETED)
        if working.done():
            return working.result()
        raise MapperError("request.gone", "The client did not wait for the answer.")
    finally:
        for task in (working, gone):
            task.cancel()
        await asyncio.gather(working, gone, return_exceptions=True)


async def _gone(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
