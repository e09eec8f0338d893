"""Brakes on requests: a client with many wrong secrets is refused for a while, and many requests of a visitor wait.

The wrong secrets of a network are counted together (an IPv6 address counts as its /64 network), and the count decreases
at a constant rate. Clients that prove a right secret by a cookie are not affected. Class codes have two brakes,
:class:`CodeGuesses`.

A request takes one to three milliseconds of the event loop, which all visitors share. Several hundred per second from
one visitor, even refused ones, would delay everyone else's frames (:class:`RequestPace`).
"""

from __future__ import annotations

import asyncio
import time
from collections import OrderedDict
from collections.abc import Callable
from math import ceil
from typing import Protocol

from starlette.types import ASGIApp, Receive, Scope, Send

from server.http.errors import error_response
from server.network_address import network_of
from server.work.token_bucket import TokenBucket
from server.workers.shared import MAX_NETWORKS


class Counts(Protocol):
    """Numbers by key, each with the time at which it was set."""

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and its time; 0 and 0 if there is none."""

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key."""


class OwnCounts:
    """The newest ``size`` numbers, for one process."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._entries: OrderedDict[str, tuple[float, float]] = OrderedDict()  #: oldest first

    def get(self, key: str) -> tuple[float, float]:
        """Return the number of a key and its time; 0 and 0 if there is none."""
        return self._entries.get(key, (0.0, 0.0))

    def set(self, key: str, number: float, at: float) -> None:
        """Set the number of a key."""
        self._entries[key] = (number, at)
        self._entries.move_to_end(key)
        while len(self._entries) > self._size:
            self._entries.popitem(last=False)


class Brake:
    """Allows ``burst`` wrong secrets of a network at once, and one more each ``60 / per_minute`` seconds.

    ``counts`` are shared by all processes of the service; None if there is only one.
    """

    def __init__(
        self,
        burst: int,
        per_minute: float,
        clock: Callable[[], float] = time.monotonic,
        counts: Counts | None = None,
    ) -> None:
        self._burst, self._per_s, self._clock = burst, per_minute / 60.0, clock
        self._wrong: Counts = OwnCounts(MAX_NETWORKS) if counts is None else counts

    def wait_s(self, address: str) -> float:
        """Return the seconds for which a network is refused; 0 if it is not."""
        return max(0.0, (self._count(network_of(address)) - self._burst + 1.0) / self._per_s)

    def count(self, address: str) -> None:
        """Count a wrong secret."""
        network = network_of(address)
        self._wrong.set(network, self._count(network) + 1.0, self._clock())

    def _count(self, network: str) -> float:
        number, at = self._wrong.get(network)
        return max(0.0, number - (self._clock() - at) * self._per_s)


class CodeGuesses:
    """Wrong codes of classes: few for one visitor, and many for one network.

    A lecture hall shares one address, and some people mistype. A guessing visitor is refused long before the hall is. A
    visitor is identified by a cookie and can drop it, so the limit of the network is what bounds guessing.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        of_visitor: Counts | None = None,
        of_network: Counts | None = None,
    ) -> None:
        """Count for this process, or for all processes that share ``of_visitor`` and ``of_network``."""
        self._of_visitor = Brake(burst=12, per_minute=12.0, clock=clock, counts=of_visitor)
        self._of_network = Brake(burst=300, per_minute=55.0, clock=clock, counts=of_network)

    def wait_s(self, visitor: str, address: str) -> float:
        """Return the seconds for which a visitor's codes, even right ones, are refused; 0 if they are not."""
        return max(self._of_visitor.wait_s(visitor), self._of_network.wait_s(address))

    def count(self, visitor: str, address: str) -> None:
        """Count a wrong code."""
        self._of_visitor.count(visitor)
        self._of_network.count(address)


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
