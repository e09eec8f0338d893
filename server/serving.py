"""Run the service: one address, one process or several workers."""

from __future__ import annotations

import asyncio
import contextlib
import io
import os
import resource
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any, NoReturn

import segno
import uvicorn
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame
from websockets.http11 import Request
from websockets.protocol import State

from mapper.core.lazy_imports import hidden_modules
from server.app import create_app
from server.http.connections import Connections, Listener, counted
from server.http.services import services_of
from server.http.uvicorn_protocol import HttpProtocol
from server.imports import UNUSED_BY_ROUTES, fast_imports
from server.library.store_check import check_stores
from server.logging import configure_logging
from server.network_address import reachable
from server.sessions import Kind
from server.settings import Settings
from server.sources import KINDS
from server.storage import StorageError, claimed
from server.stream.frames import EXTENSION
from server.warm_up import WarmUp, load_sessions
from server.workers.supervisor import in_child, supervise
from server.workers.worker import REPLACE, Worker

BACKLOG = 2048
UNGUARDED = "no token is required: everyone who can reach the service may upload logs and use all functions."
THREADS_END_S = 1.0  #: seconds in which threads must end after the service is closed
MAX_AHEAD = 8  #: messages of a WebSocket that may wait for the application before reading pauses
UPLOADS_S = 600.0  #: seconds that a worker to be replaced waits for running uploads
UNREAD_MS = 30_000  #: milliseconds without acknowledgement of sent data after which a connection is closed


def class_invitation(code: str, netloc: str) -> str:
    """Return the address of a class, as text and as a QR code of characters, for a terminal."""
    address = f"http://{netloc}/class/{code}"
    out = io.StringIO()
    segno.make(address, error="m", micro=False).terminal(out, compact=True, border=2)
    return f"The class {code} is open at {address}\n{out.getvalue()}"


def address_of(host: str, port: int, token: str | None) -> str:
    """Return the URL to open in a browser, with a wildcard address replaced by loopback."""
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
        # Accepted sockets inherit it. A client that never reads would hold a session endlessly, because closing waits
        # until all sent data is acknowledged. (Linux only; elsewhere the session's idle time is the only limit.)
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
    """uvicorn's WebSocket protocol, which closes a connection whose handshake cannot be parsed.

    uvicorn would keep it open without an answer and raise an error at shutdown, so that sessions would not be closed.
    It also accepts complete frames, see :data:`server.stream.frames.EXTENSION`.
    """

    on_text: Callable[[bytes], bool] | None = None

    def handle_connect(self, event: Request) -> None:
        """Start the application for a handshake."""
        super().handle_connect(event)
        if not self.handshake_complete:  # the handshake was not refused
            self.scope["extensions"][EXTENSION] = {"socket": self}

    def handle_text(self, event: Frame) -> None:
        """Pass a text message to the application."""
        takes = self.on_text is not None and event.fin and self.queue.empty() and not self.close_sent
        if not (takes and self.on_text(bytes(event.data))):  # type: ignore[misc]
            super().handle_text(event)

    def send_receive_event_to_app(self) -> None:
        """Queue a message for the application.

        uvicorn pauses reading at each message and resumes it afterwards, which takes two system calls for an
        acknowledgement of 30 bytes. Here only a client that is :data:`MAX_AHEAD` messages ahead waits.
        """
        was_paused = self.read_paused
        is_ahead = self.queue.qsize() >= MAX_AHEAD
        self.read_paused = was_paused or not is_ahead
        super().send_receive_event_to_app()
        self.read_paused = was_paused or is_ahead

    def is_ready(self) -> bool:
        """Return whether the client is connected, and has read enough of the earlier data."""
        is_open = not (self.disconnected or self.close_sent) and self.conn.state is State.OPEN
        return is_open and self.writable.is_set()

    def write(self, frames: bytes) -> None:
        """Write complete frames."""
        self.transport.write(frames)

    async def send(self, message: Any) -> None:  # noqa: ANN401 - an ASGI message, with an extension
        """Send a message of the application."""
        frames = message.get("frames")
        if frames is None:
            await super().send(message)
            return
        await self.writable.wait()
        if self.disconnected or self.close_sent or self.conn.state is not State.OPEN:
            raise ClientDisconnected
        self.transport.write(frames)

    def data_received(self, data: bytes) -> None:
        """Process received bytes."""
        super().data_received(data)
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self.transport.close()


class Server(uvicorn.Server):
    """A uvicorn server that limits its number of ``connections``. While it runs, ``warm_up`` may compile kernels.

    ``worker`` is this worker, if there are several; it also accepts the connections that others hand over to it.
    """

    def __init__(
        self,
        config: uvicorn.Config,
        connections: Connections,
        warm_up: WarmUp | None = None,
        worker: Worker | None = None,
    ) -> None:
        super().__init__(config)
        self.connections, self.warm_up, self.worker = connections, warm_up, worker
        self._taking: set[asyncio.Task[None]] = set()
        self._ending: asyncio.Task[None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen on the sockets."""
        await super().startup([Listener(socket, self.connections) for socket in sockets or ()])
        if self.warm_up is not None and not self.should_exit:
            self.warm_up.begin()
        if self.worker is not None:
            self.worker.end_with_supervisor()
            figures = services_of(self.config.app).metrics.text  # type: ignore[arg-type]
            self.worker.handover.begin(self._take, figures)
            asyncio.get_running_loop().add_signal_handler(REPLACE, self._begin_to_end)

    def _begin_to_end(self) -> None:
        """End once no upload is running, or after :data:`UPLOADS_S`."""
        self._ending = asyncio.create_task(self._end_after_uploads())

    async def _end_after_uploads(self) -> None:
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(services_of(self.config.app).library.end_uploads(), UPLOADS_S)  # type: ignore[arg-type]
        self.should_exit = True

    def _take(self, passed_on: socket.socket, head: bytes) -> None:
        """Accept a connection of which another worker has read ``head``."""
        taking = asyncio.create_task(self._begin_with(passed_on, head))
        self._taking.add(taking)
        taking.add_done_callback(self._taking.discard)

    async def _begin_with(self, passed_on: socket.socket, head: bytes) -> None:
        with contextlib.suppress(OSError):  # the client has disconnected
            connection = counted(passed_on, str(passed_on.getpeername()[0]), self.connections)
            if connection is None:
                return
            protocol: Callable[[], asyncio.Protocol] = partial(
                self.config.http_protocol_class,  # type: ignore[call-arg]
                config=self.config,
                server_state=self.server_state,
                app_state=self.lifespan.state,
                passed_on=head,
            )
            await asyncio.get_running_loop().connect_accepted_socket(protocol, connection)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close all connections and end the started tasks."""
        if self.worker is not None:
            self.worker.handover.end()
        if self.warm_up is not None:
            self.warm_up.end()
        await super().shutdown(sockets)


def make_server(settings: Settings, kinds: Mapping[str, Kind] = KINDS, worker: Worker | None = None) -> Server:
    """Return a uvicorn server of the service with sessions of these kinds, not yet running. Run it on sockets.

    ``worker`` is the worker to which the settings belong, if there are several.
    """
    handover = None if worker is None else worker.handover
    elsewhere = None if worker is None else worker.connections
    connections = Connections(settings.max_connections, settings.max_connections_per_address, elsewhere)
    app = create_app(settings, kinds, worker)
    return Server(
        uvicorn.Config(
            app,
            loop="asyncio",  # other loops accept connections themselves, without the limits
            http=partial(  # type: ignore[arg-type]
                HttpProtocol, connections=connections, header_s=settings.header_timeout_s, handover=handover
            ),
            ws=Socket,
            ws_per_message_deflate=False,  # tiles are already compressed
            ws_max_size=1 << 20,
            ws_ping_interval=20.0,
            ws_ping_timeout=20.0,
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=list(settings.trusted_proxies),
            access_log=False,  # access lines would contain the token
            log_config=None,
            server_header=False,
            timeout_graceful_shutdown=2,
        ),
        connections,
        WarmUp() if settings.compile_ahead and (worker is None or worker.number == 0) else None,
        worker,
    )


def run(settings: Settings) -> None:
    """Serve until interrupted. Exits with status 1 and one sentence if the address or a store cannot be used."""
    settings = settings.with_token()
    configure_logging(settings.log_format, settings.log_level)
    with contextlib.ExitStack() as held:
        held.enter_context(hidden_modules(*UNUSED_BY_ROUTES))
        with _or_exit(f"cannot keep data in {settings.data_dir}", "Choose another folder with --data-dir."):
            settings.data_dir.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=settings.data_dir):
                pass
            held.enter_context(claimed(settings.data_dir))
        if settings.workers == 1:
            _check_stores(settings)
        else:  # the stores have threads, which this process must not have when it is forked
            in_child(partial(_check_stores, settings))
        _serve(settings)


def _check_stores(settings: Settings) -> None:
    try:
        with fast_imports():  # it imports SQLAlchemy
            check_stores(settings)
    except StorageError as error:
        print(f"gridbloom: {error.message}", file=sys.stderr)
        raise SystemExit(1) from None


def _serve(settings: Settings) -> None:
    address = f"{settings.host} port {settings.port}"
    with _or_exit(f"cannot listen on {address}", "Choose another with --port, or --port 0 for a free one."):
        bound = listen(settings.host, settings.port)
    _take_all_descriptors()
    with bound:
        token = None if settings.token is None else settings.token.get_secret_value()
        server = make_server(settings) if settings.workers == 1 else None
        if settings.is_reached_from_beyond and token is None:
            print(f"gridbloom: warning: {UNGUARDED}", file=sys.stderr)
        port = bound.getsockname()[1]
        print(f"Gridbloom runs at {address_of(settings.host, port, token)}", flush=True)
        if settings.class_code is not None:
            print(class_invitation(settings.class_code, reachable(f"127.0.0.1:{port}")), flush=True)
        if server is None:
            with fast_imports():
                load_sessions()
            supervise(
                settings.workers,
                lambda worker: _run(make_server(settings.of_worker(worker.number), worker=worker), bound),
                settings.class_code,
            )
        else:
            _run(server, bound)


def _run(server: Server, bound: socket.socket) -> None:
    # uvicorn shuts down and raises the signal again: this handler then ends the process with status 0.
    signal.signal(signal.SIGTERM, _end)
    signal.signal(signal.SIGINT, _end)
    server.run(sockets=[bound])


@contextmanager
def _or_exit(what: str, advice: str) -> Iterator[None]:
    """End the process with status 1 and one sentence on an error of the system or a store."""
    try:
        yield
    except (OSError, StorageError) as error:
        reason = error.message if isinstance(error, StorageError) else error.strerror or error
        print(f"gridbloom: {what}: {reason}. {advice}", file=sys.stderr)
        raise SystemExit(1) from None


def _take_all_descriptors() -> None:
    """Raise the limit of open files to its maximum: each browser needs one, and the default is often 1024."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        with contextlib.suppress(ValueError, OSError):  # macOS reports a limit that it does not grant
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))


def _end(*_: object) -> NoReturn:
    """End the process; stores and sessions are already closed.

    Python waits for its threads, and a thread that compiles a kernel cannot be interrupted. After :data:`THREADS_END_S`
    the process ends without waiting for it.
    """
    left_behind = threading.Timer(THREADS_END_S, os._exit, (0,))
    left_behind.daemon = True
    try:
        left_behind.start()
    except (RuntimeError, MemoryError):  # no memory for a thread
        os._exit(0)
    raise SystemExit(0)
