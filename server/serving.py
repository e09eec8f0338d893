"""Run the service: one address, one process."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import NoReturn

import uvicorn
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from server.app import create_app
from server.http.connections import Connections, Listener
from server.http.uvicorn_protocol import HttpProtocol
from server.library import StorageError, check_stores, claimed
from server.logging import configure_logging
from server.sessions import KINDS, Kind
from server.settings import Settings

BACKLOG = 2048
UNGUARDED = "no token is asked for: whoever reaches the service may upload logs and use all that it has."
THREADS_END_S = 1.0  #: seconds in which threads have to end once the service is closed
UNREAD_MS = 30_000  #: a connection whose other end takes in nothing of what was sent for so long is given up


def address_of(host: str, port: int, token: str | None) -> str:
    """Return the address that a person opens: an address that stands for all addresses is not one to open."""
    name = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(host, host)  # noqa: S104 - compared, not bound
    name = f"[{name}]" if ":" in name and not name.startswith("[") else name
    return f"http://{name}:{port}/" + (f"?token={token}" if token else "")


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens on the address. Raises :class:`OSError`."""
    infos = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    family, kind, protocol, _, address = infos[0]
    bound = socket.socket(family, kind, protocol)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Accepted sockets inherit it. Whoever never reads would hold a session and its place for ever: a close waits
        # until everything sent before it was taken in. (Linux; elsewhere the session's idle time is all there is.)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNREAD_MS)
        bound.bind(address)
        bound.listen(BACKLOG)
        bound.setblocking(False)
    except OSError:
        bound.close()
        raise
    return bound


class Socket(WebSocketsSansIOProtocol):
    """uvicorn's end of a WebSocket, which gives up a connection whose handshake cannot even be read.

    uvicorn would keep it, without an answer, and stumble over it when it ends: the sessions would not be closed.
    """

    def data_received(self, data: bytes) -> None:
        """Take in bytes."""
        super().data_received(data)
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self.transport.close()


class Server(uvicorn.Server):
    """A uvicorn server that keeps to its number of ``connections``."""

    def __init__(self, config: uvicorn.Config, connections: Connections) -> None:
        super().__init__(config)
        self.connections = connections

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen on the sockets."""
        await super().startup([Listener(one, self.connections) for one in sockets or ()])


def make_server(settings: Settings, kinds: Mapping[str, Kind] = KINDS) -> Server:
    """Return a uvicorn server of the service with sessions of these kinds, not yet running. Run it on sockets."""
    connections = Connections(settings.max_connections, settings.max_connections_per_address)
    return Server(
        uvicorn.Config(
            create_app(settings, kinds),
            loop="asyncio",  # others accept connections by themselves, without the caps
            http=partial(HttpProtocol, connections=connections, header_s=settings.header_timeout_s),  # type: ignore[arg-type]
            ws=Socket,
            ws_per_message_deflate=False,  # tiles are compressed already
            ws_max_size=1 << 20,
            ws_ping_interval=20.0,
            ws_ping_timeout=20.0,
            access_log=False,  # its lines would hold the token of the first address
            log_config=None,
            server_header=False,
            timeout_graceful_shutdown=2,
        ),
        connections,
    )


def run(settings: Settings) -> None:
    """Serve until interrupted. Exits with status 1 and one sentence where the address or a store cannot be had."""
    settings = settings.with_token()
    configure_logging(settings.log_format, settings.log_level)
    with contextlib.ExitStack() as held:
        with _or_exit(f"cannot keep data in {settings.data_dir}", "Choose another folder with --data-dir."):
            settings.data_dir.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=settings.data_dir):
                pass
            held.enter_context(claimed(settings.data_dir))
        try:
            check_stores(settings)
        except StorageError as error:
            print(f"gridbloom: {error.message}", file=sys.stderr)
            raise SystemExit(1) from None
        _serve(settings)


def _serve(settings: Settings) -> None:
    address = f"{settings.host} port {settings.port}"
    with _or_exit(f"cannot listen on {address}", "Choose another with --port, or --port 0 for a free one."):
        bound = listen(settings.host, settings.port)
    _take_all_descriptors()
    with bound:
        server = make_server(settings)
        token = None if settings.token is None else settings.token.get_secret_value()
        # uvicorn ends what runs and then raises the signal again: it ends the process here, and in good order.
        signal.signal(signal.SIGTERM, _end)
        signal.signal(signal.SIGINT, _end)
        if settings.is_reached_from_beyond and token is None:
            print(f"gridbloom: warning: {UNGUARDED}", file=sys.stderr)
        print(f"Gridbloom runs at {address_of(settings.host, bound.getsockname()[1], token)}", flush=True)
        server.run(sockets=[bound])


@contextmanager
def _or_exit(what: str, advice: str) -> Iterator[None]:
    """End the process with one sentence where the system refuses something."""
    try:
        yield
    except (OSError, StorageError) as error:
        reason = error.message if isinstance(error, StorageError) else error.strerror or error
        print(f"gridbloom: {what}: {reason}. {advice}", file=sys.stderr)
        raise SystemExit(1) from None


def _take_all_descriptors() -> None:
    """Raise the limit of open files as far as the system lets it: each browser is one, and the usual 1024 are few."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        with contextlib.suppress(ValueError, OSError):  # macOS states a limit that it does not grant
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def _end(*_: object) -> NoReturn:
    """End the process; everything that has to be closed is closed.

    Python waits for its threads, and a thread that compiles a kernel cannot be interrupted.
    """
    left_behind = threading.Timer(THREADS_END_S, os._exit, (0,))
    left_behind.daemon = True
    left_behind.start()
    raise SystemExit(0)
