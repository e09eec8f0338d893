"""uvicorn's HTTP/1.1 protocol with a deadline for request headers and closable waiting connections.

uvicorn itself has no time limit for the headers of a connection that has sent a byte, nor for the rest of a body after
it has answered.
"""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from server.http.connections import Connections

REST_S = 60.0  #: seconds within which the rest of a body must arrive after its answer


class HttpProtocol(H11Protocol):
    """One connection. Complete headers must arrive within ``header_s`` seconds."""

    def __init__(self, *arguments: Any, connections: Connections, header_s: float, **more: Any) -> None:  # noqa: ANN401
        super().__init__(*arguments, **more)
        self._open = connections
        self._header_s = header_s
        self._deadline: asyncio.TimerHandle | None = None
        self._descriptor = -1

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._descriptor = transport.get_extra_info("socket").fileno()
        self._open.made(self._descriptor)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop waiting for a request."""
        self._stop_waiting()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Process received bytes."""
        super().data_received(data)
        self._look()

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        super().on_response_complete()
        self._look()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Switch the connection to the WebSocket protocol."""
        self._stop_waiting()
        super().handle_websocket_upgrade(event)

    def _look(self) -> None:
        """Check whether a request is running."""
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return
        # There is no cycle before the first request.
        if self.cycle is not None and not self.cycle.response_complete:  # type: ignore[redundant-expr]
            self._stop_waiting()
        elif self._deadline is None:
            self._wait()

    def _wait(self) -> None:
        seconds = REST_S if self.conn.their_state is h11.SEND_BODY else self._header_s
        self._deadline = self.loop.call_later(seconds, self.timeout_keep_alive_handler)
        self._open.wait(self._descriptor, self.transport.close)

    def _stop_waiting(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
        self._open.work(self._descriptor)
