"""The end of a viser server: no connection outlives it, whenever it came."""

from __future__ import annotations

import gc
import socket
from contextlib import suppress

import pytest

from server.scenes.viser_server import ViserServer
from tests.server.service import PATIENCE_S


@pytest.mark.parametrize("rounds", range(6))
def test_a_connection_that_comes_while_the_server_ends_is_closed(rounds: int) -> None:
    """It comes some rounds of the server's loop after the server was told to end."""
    server, connected = ViserServer(), list[socket.socket]()
    loop, stopping = server._websock_server._background_event_loop, server._websock_server._stop_event
    assert loop is not None
    assert stopping is not None
    with socket.socket(socket.AF_UNIX) as client:
        client.settimeout(PATIENCE_S)

        def end_and_connect(path: str, left: int) -> None:
            if left == rounds:
                stopping.set()
            if left > 0:
                loop.call_soon(end_and_connect, path, left - 1)
                return
            with suppress(ConnectionRefusedError, FileNotFoundError):  # the server has ended
                client.connect(path)
                client.shutdown(socket.SHUT_WR)  # a request will not come: the server need not wait for it
                connected.append(client)

        loop.call_soon_threadsafe(end_and_connect, str(server.path), rounds)
        server.stop()
        if connected:
            with suppress(ConnectionError):
                while client.recv(4096):  # a refusal, or nothing, and then the end
                    pass
    del server
    gc.collect()  # an open socket would be an error
