"""Limits on open connections, in total and per address, before authentication.

A connection without a running request is *waiting*: it was just opened, its headers are incomplete, or it is kept alive
for another request. At the limit, a new connection replaces the one that has waited longest; if none waits, the new one
is closed. Idle connections therefore cannot block new ones.
"""

from __future__ import annotations

import contextlib
import errno
import os
import resource
import socket
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import structlog

from server.network_address import network_of

BATCH = 32  #: connections accepted in one pass of the event loop
SAY_EVERY_S = 10.0  #: least seconds between two log lines about refused connections
DESCRIPTORS = 0.75  #: share of the file descriptors for connections; files and 3D views need the rest
OUT_OF_RESOURCES = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})

_log = structlog.get_logger(__name__)


@dataclass(slots=True)
class _Open:
    """An open connection: its network, and how to close it while it waits (None during a request)."""

    network: str
    end: Callable[[], None] | None = None


class Elsewhere(Protocol):
    """The non-waiting connections of the other workers of a service; a waiting one can only be ended by its worker."""

    def others(self, network: str) -> tuple[int, int]:
        """Return their numbers: in total, and for a network."""

    def add(self, network: str, number: int) -> None:
        """Add ``number`` to the count of a network in this worker."""


class _Nowhere(Elsewhere):
    """No other workers, for a service with one process."""

    def others(self, network: str) -> tuple[int, int]:  # noqa: ARG002
        return 0, 0

    def add(self, network: str, number: int) -> None:
        pass


class Connections:
    """The open connections, at most ``most`` and ``most_of_address`` from one address. Used on the event loop only.

    Non-waiting connections ``elsewhere`` count too. An IPv6 address counts as its /64 network. The limit on file
    descriptors bounds the number of connections open here.
    """

    def __init__(self, most: int, most_of_address: int, elsewhere: Elsewhere | None = None) -> None:
        self._most = most
        self._most_here = int(resource.getrlimit(resource.RLIMIT_NOFILE)[0] * DESCRIPTORS)
        self._most_of_network = most_of_address
        self._elsewhere = elsewhere or _Nowhere()
        self._open: dict[int, _Open] = {}  #: by descriptor
        self._count: Counter[str] = Counter()  #: by network
        self._waiting: defaultdict[str, dict[int, None]] = defaultdict(dict)  #: by network, the longest waiting first
        self._all_waiting: dict[int, None] = {}
        self._coming: set[int] = set()  #: accepted, but without a protocol yet
        self._refused = 0
        self._said_s = -SAY_EVERY_S

    def __len__(self) -> int:
        return len(self._open)

    @property
    def is_batch_full(self) -> bool:
        """Whether accepting pauses until the event loop has created protocols for the accepted connections."""
        return len(self._coming) >= BATCH

    def admit(self, descriptor: int, address: str) -> bool:
        """Count a new connection; return False if the limit is reached."""
        network = network_of(address)
        others, of_network = self._elsewhere.others(network)
        is_full = self._count.get(network, 0) + of_network >= self._most_of_network
        if is_full and not self._end_one(self._waiting.get(network, {})):
            self.refuse("as many connections as one address may have")
            return False
        is_full = len(self) >= min(self._most - others, self._most_here)
        if is_full and not self._end_one(self._all_waiting):
            self.refuse("as many connections as there may be")
            return False
        self._open[descriptor] = _Open(network)
        self._count[network] += 1
        self._elsewhere.add(network, 1)
        self._coming.add(descriptor)
        return True

    def made(self, descriptor: int) -> None:
        """Record that a connection has its protocol."""
        self._coming.discard(descriptor)

    def wait(self, descriptor: int, end: Callable[[], None]) -> None:
        """Record that a connection waits for a request, and how to end it."""
        connection = self._open.get(descriptor)
        if connection is None:
            return
        connection.end = end
        if descriptor not in self._all_waiting:
            self._elsewhere.add(connection.network, -1)
        self._all_waiting[descriptor] = None
        self._waiting[connection.network][descriptor] = None

    def work(self, descriptor: int) -> None:
        """Record that a connection serves a request, or is a WebSocket."""
        connection = self._open.get(descriptor)
        if connection is not None and descriptor in self._all_waiting:
            del self._all_waiting[descriptor]
            del self._waiting[connection.network][descriptor]
            self._elsewhere.add(connection.network, 1)

    def closed(self, descriptor: int) -> None:
        """Remove a connection."""
        self.made(descriptor)
        self.work(descriptor)
        connection = self._open.pop(descriptor, None)
        if connection is None:
            return
        self._count[connection.network] -= 1
        self._elsewhere.add(connection.network, -1)
        if not self._count[connection.network]:
            del self._count[connection.network]
            self._waiting.pop(connection.network, None)

    def refuse(self, reason: str) -> None:
        """Log that connections are refused, at most every :data:`SAY_EVERY_S` seconds."""
        self._refused += 1
        now = time.monotonic()
        if now - self._said_s >= SAY_EVERY_S:
            _log.warning("connections refused", reason=reason, refused=self._refused, open=len(self))
            self._refused, self._said_s = 0, now

    def _end_one(self, waiting: dict[int, None]) -> bool:
        descriptor = next(iter(waiting), None)
        if descriptor is None:
            return False
        end = self._open[descriptor].end
        self.closed(descriptor)
        if end is not None:
            end()
        return True


class _Connection(socket.socket):
    """A socket that calls back when it is closed."""

    on_close: Callable[[int], None] | None = None

    def close(self) -> None:
        """Close the socket."""
        if self.on_close is not None and self.fileno() >= 0:
            self.on_close(self.fileno())
        super().close()


def counted(accepted: socket.socket, address: str, connections: Connections) -> socket.socket | None:
    """Return a connection that is counted until it is closed. At the limit, close it and return None."""
    if not connections.admit(accepted.fileno(), address):
        accepted.close()
        return None
    connection = _Connection(accepted.family, accepted.type, accepted.proto, fileno=accepted.detach())
    connection.on_close = connections.closed
    return connection


class Listener(socket.socket):
    """A duplicate of the listening socket ``bound`` that accepts connections up to the limits.

    If there are no more file descriptors, it releases a spare one to close the waiting connection. Otherwise the event
    loop would be woken for it endlessly, and log a traceback each time.
    """

    def __init__(self, bound: socket.socket, connections: Connections) -> None:
        super().__init__(bound.family, bound.type, bound.proto, fileno=os.dup(bound.fileno()))
        self.setblocking(False)
        self._connections = connections
        self._spare = os.open(os.devnull, os.O_RDONLY)

    def accept(self) -> tuple[socket.socket, Any]:
        """Return a new connection and its address. Raises :class:`BlockingIOError` if none is waiting."""
        for _ in range(0 if self._connections.is_batch_full else BATCH):
            try:
                accepted, address = super().accept()
            except OSError as error:
                if error.errno not in OUT_OF_RESOURCES:
                    raise
                self._refuse_one()
                break
            connection = counted(accepted, str(address[0]), self._connections)
            if connection is not None:
                return connection, address
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    def _refuse_one(self) -> None:
        """Close the connection that has waited longest to be accepted."""
        self._connections.refuse("no descriptors are left")
        if self._spare >= 0:
            os.close(self._spare)
            self._spare = -1
        with contextlib.suppress(OSError):
            super().accept()[0].close()
        with contextlib.suppress(OSError):
            self._spare = os.open(os.devnull, os.O_RDONLY)

    def close(self) -> None:
        """Close the socket and the spare descriptor."""
        if self._spare >= 0:
            os.close(self._spare)
            self._spare = -1
        super().close()
