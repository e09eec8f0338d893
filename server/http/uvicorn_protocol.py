"""uvicorn's HTTP/1.1 protocol with a deadline for request headers and closable waiting connections.

uvicorn itself has no time limit for the headers of a connection that has sent a byte, nor for the rest of a body after
it has answered. If the service has several workers, a connection whose next request is for another one is handed over.
"""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from server.http.connections import Connections
from server.workers.handover import MAX_HEAD, Handover

AGAIN_S = 0.02  #: retry interval of handing a connection over to a worker with a full buffer
REST_S = 60.0  #: seconds within which the rest of a body must arrive after its answer


class HttpProtocol(H11Protocol):
    """One connection. Complete headers must arrive within ``header_s`` seconds.

    ``handover`` hands connections over to other workers; None if there are none. ``passed_on`` is the data of this
    connection that another worker has read, whose first request is for this worker.
    """

    def __init__(
        self,
        *arguments: Any,  # noqa: ANN401
        connections: Connections,
        header_s: float,
        handover: Handover | None = None,
        passed_on: bytes = b"",
        **more: Any,  # noqa: ANN401
    ) -> None:
        super().__init__(*arguments, **more)
        self._open = connections
        self._header_s = header_s
        self._handover = handover
        self._passed_on = passed_on
        self._head = b""  #: the read part of a request whose worker is not known yet
        self._deadline: asyncio.TimerHandle | None = None
        self._descriptor = -1

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start waiting for a request."""
        super().connection_made(transport)
        self._descriptor = transport.get_extra_info("socket").fileno()
        self._open.made(self._descriptor)
        self._wait()
        if self._passed_on:
            self._answer(self._passed_on)

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop waiting for a request."""
        self._stop_waiting()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Process received bytes."""
        if self._handover is None or not self._is_between_requests:
            self._answer(data)
            return
        self._unset_keepalive_if_required()
        self._head += data
        if len(self._head) > MAX_HEAD or b"\r\n\r\n" in self._head:
            self._choose(self._handover)

    @property
    def _is_between_requests(self) -> bool:
        return self.conn.their_state is h11.IDLE and self.conn.our_state is h11.IDLE and not self.conn.trailing_data[0]

    def _choose(self, handover: Handover) -> None:
        """Hand the connection over, or answer the request here."""
        if self.transport.is_closing():
            return
        # Impossible if the client has not read the last answer, because this process has the unsent part.
        worker = None
        if b"\r\n\r\n" in self._head[:MAX_HEAD] and not self.transport.get_write_buffer_size():
            worker = handover.other(self._head, self.client[0] if self.client else "")
        if worker is None:
            head, self._head = self._head, b""
            self._answer(head)
        elif handover.pass_on(worker, self._head, self._descriptor):
            self.transport.abort()  # closes only this process's descriptor
        else:
            self.transport.pause_reading()
            self.loop.call_later(AGAIN_S, self._choose_again, handover)

    def _choose_again(self, handover: Handover) -> None:
        if not self.transport.is_closing():
            self.transport.resume_reading()
            self._choose(handover)

    def _answer(self, data: bytes) -> None:
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
