"""Run the service: one address, one process."""

from __future__ import annotations

import contextlib
import signal
import socket
import sys
from typing import NoReturn

import uvicorn

from server.app import create_app
from server.logging import configure_logging
from server.settings import Settings

BACKLOG = 2048


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
        bound.bind(address)
        bound.listen(BACKLOG)
        bound.setblocking(False)
    except OSError:
        bound.close()
        raise
    return bound


def make_server(settings: Settings) -> uvicorn.Server:
    """Return a uvicorn server of the service, not yet running."""
    return uvicorn.Server(
        uvicorn.Config(
            create_app(settings),
            ws="websockets-sansio",
            ws_per_message_deflate=False,  # tiles are compressed already
            ws_max_size=1 << 20,
            ws_ping_interval=20.0,
            ws_ping_timeout=20.0,
            access_log=False,  # its lines would hold the token of the first address
            log_config=None,
            server_header=False,
            timeout_graceful_shutdown=5,
        )
    )


def run(settings: Settings) -> None:
    """Serve until interrupted. Exits with status 1 and one sentence where the address cannot be had."""
    settings = settings.with_token()
    configure_logging(settings.log_format, settings.log_level)
    try:
        bound = listen(settings.host, settings.port)
    except OSError as error:
        reason = error.strerror or str(error)
        print(
            f"gridbloom: cannot listen on {settings.host} port {settings.port}: {reason}. "
            "Choose another with --port, or --port 0 for a free one.",
            file=sys.stderr,
        )
        raise SystemExit(1) from None
    with bound:
        server = make_server(settings)
        token = None if settings.token is None else settings.token.get_secret_value()
        print(f"Gridbloom runs at {address_of(settings.host, bound.getsockname()[1], token)}", flush=True)
        # uvicorn ends what runs and then raises the signal again: it ends the process here, and in good order.
        signal.signal(signal.SIGTERM, _end)
        with contextlib.suppress(KeyboardInterrupt):
            server.run(sockets=[bound])


def _end(*_: object) -> NoReturn:
    raise SystemExit(0)
