"""Limit of the requests of one visitor that are answered per second. Further ones wait.

A request takes one to three milliseconds of the event loop, which all visitors share. Several hundred per second from
one visitor, even refused ones, would delay everyone else's frames.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from math import ceil

from starlette.types import ASGIApp, Receive, Scope, Send

from server.http.errors import error_response
from server.network_address import network_of
from server.work.token_bucket import TokenBucket

VISITOR_BURST, VISITOR_PER_S = 500.0, 30.0  #: a page takes 20 to 40 requests to open
NETWORK_BURST, NETWORK_PER_S = 5000.0, 300.0  #: a lecture hall shares one address
MAX_WAIT_S = 10.0  #: a request that would wait longer is refused
MAX_KNOWN = 8192  #: number of visitors and networks stored


class RequestPace:
    """Middleware inside of :class:`server.http.security.Security`, which identifies visitors."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._buckets: OrderedDict[tuple[str, str], TokenBucket] = OrderedDict()  #: longest unused first

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a request in its turn, or refuse it if too many wait."""
        if scope["type"] != "http":  # the sockets of a visitor are limited in number
            await self._app(scope, receive, send)
            return
        address = (scope.get("client") or ("",))[0]
        buckets = (
            self._bucket(("visitor", scope["state"]["visitor"]), VISITOR_BURST, VISITOR_PER_S),
            self._bucket(("network", network_of(address)), NETWORK_BURST, NETWORK_PER_S),
        )
        wait_s = max(bucket.wait_s for bucket in buckets)
        if wait_s > MAX_WAIT_S:
            headers = {"Retry-After": str(ceil(wait_s))}
            response = error_response(429, "request.too_many", "Too many requests at once.", headers=headers)
            await response(scope, receive, send)
            return
        for bucket in buckets:
            bucket.spend()
        if wait_s > 0.0:
            await asyncio.sleep(wait_s)
        await self._app(scope, receive, send)

    def _bucket(self, key: tuple[str, str], burst: float, per_s: float) -> TokenBucket:
        bucket = self._buckets.get(key)
        if bucket is None:
            bucket = self._buckets[key] = TokenBucket(burst, per_s)
            while len(self._buckets) > MAX_KNOWN:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(key)
        return bucket
