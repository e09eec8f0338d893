"""The exchange of messages between one browser and a session; see :mod:`server.stream.protocol`."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass
from typing import Any

import structlog
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from server.sessions import SessionBudgetError, SessionHost
from server.sessions.tick import error_message
from server.stream.close_codes import ENDED, INTERNAL, NO_ACKS, POLICY, CloseCode
from server.stream.frames import EXTENSION, binary_frame
from server.stream.hub import Client
from server.stream.protocol import SUBPROTOCOL, ProtocolError, decode_command, integer, text
from server.work.waiting import set_within

MAX_MALFORMED = 20  #: frames that break the protocol before the socket is closed
COMMANDS_PER_S, COMMAND_BURST = 120.0, 240.0
LEAVING_S = 1.0  #: for pages to leave a session that their class does not show any more
MAX_THROTTLED = 1200  #: commands in a row that came too fast, before the socket is closed

_log = structlog.get_logger(__name__)


class Allowance:
    """A token bucket that limits the commands of one client: above the rate they are read more slowly."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._left, self._at = COMMAND_BURST, clock()

    def spend(self) -> float:
        """Count one command; return the seconds to wait before the next one is read."""
        now = self._clock()
        self._left = min(COMMAND_BURST, self._left + (now - self._at) * COMMANDS_PER_S) - 1.0
        self._at = now
        return max(0.0, -self._left / COMMANDS_PER_S)


@dataclass(frozen=True, slots=True)
class Following:
    """A client that follows the lecturer of a class: it sees the session, and its commands are refused.

    ``may`` says whether a command of that type is allowed all the same. ``over`` is set once the class does not show
    the session any more: the connection then ends.
    """

    may: Callable[[str], bool]
    over: asyncio.Event


async def exchange(
    websocket: WebSocket, session: SessionHost, max_clients: int, following: Following | None = None
) -> None:
    """Accept the WebSocket, if the session has fewer than ``max_clients`` clients, and exchange messages until it ends.

    Followers of a class and others are counted apart.

    Raises :class:`SessionBudgetError` before the socket is accepted.
    """
    if SUBPROTOCOL not in websocket.scope["subprotocols"]:
        await websocket.accept()
        await websocket.close(POLICY.code, f"the subprotocol {SUBPROTOCOL} is required")
        return
    follows = following is not None
    if sum(client.follows == follows for client in session.hub.clients) >= max_clients:
        raise SessionBudgetError("session.crowded", "As many browsers as may watch this session already.")
    await websocket.accept(subprotocol=SUBPROTOCOL)
    client = session.join(follows=follows)
    tasks = [
        asyncio.create_task(_send(websocket, session, client), name="stream out"),
        asyncio.create_task(_receive(websocket, session, client, following), name="stream in"),
    ]
    if following is not None:
        tasks.append(asyncio.create_task(_leave(following.over), name="session of a class"))
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        session.leave(client)
        for task in tasks:
            task.cancel()
        done = await asyncio.gather(*tasks, return_exceptions=True)
        for result in done:
            if isinstance(result, Exception) and not isinstance(result, WebSocketDisconnect):
                _log.error("a stream failed", exc_info=result)
                await _close(websocket, INTERNAL, "internal")
        if following is not None and following.over.is_set():
            await _close(websocket, ENDED, "class.not_shown")


async def _leave(over: asyncio.Event) -> None:
    """Return a while after ``over``: the page hears of it from the class and ends the connection without an error."""
    await over.wait()
    await asyncio.sleep(LEAVING_S)


async def _close(websocket: WebSocket, code: CloseCode, reason: str) -> None:
    if websocket.application_state is WebSocketState.CONNECTED:
        # The browser may have disconnected meanwhile.
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await websocket.close(code.code, reason)


async def _send(websocket: WebSocket, session: SessionHost, client: Client) -> None:
    takes_frames = EXTENSION in websocket.scope.get("extensions", {})
    while True:
        client.wake.clear()
        messages = client.take()
        if client.follows:
            # Whoever knows the id of a session can control it.
            messages = [_without_id(message, session.id) for message in messages]
        if takes_frames and messages:
            frames = [
                binary_frame((one,)) if isinstance(one, bytes) else session.hub.text_frame(one) for one in messages
            ]
            await websocket.send({"type": "websocket.send", "frames": b"".join(frames)})
        else:
            for message in messages:
                await (websocket.send_bytes(message) if isinstance(message, bytes) else websocket.send_text(message))
        if session.closed:
            await _close(websocket, ENDED, "session.ended")
            return
        if client.is_lost:
            await _close(websocket, NO_ACKS, "no frame was acknowledged for a long time")
            return
        await set_within(client.wake, client.wait_s())


def _without_id(message: str | bytes, session_id: str) -> str | bytes:
    if isinstance(message, str) and message.startswith('{"type":"hello"'):
        return message.replace(session_id, "")
    return message


async def _receive(websocket: WebSocket, session: SessionHost, client: Client, following: Following | None) -> None:
    malformed = throttled = 0
    allowance = Allowance()
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return
        try:
            _take(session, client, _decode(message), following)
        except ProtocolError as error:
            client.send(error_message(error.code, error.message))
            malformed += error.code.startswith("command.")
            if malformed > MAX_MALFORMED:
                await _close(websocket, POLICY, "too many malformed frames")
                return
        wait = allowance.spend()
        throttled = throttled + 1 if wait > 0.0 else 0
        if throttled > MAX_THROTTLED:
            await _close(websocket, POLICY, "too many commands")
            return
        if wait > 0.0:  # the allowance also bounds how many commands are taken in one pass of the event loop
            await asyncio.sleep(wait)


def _decode(message: MutableMapping[str, Any]) -> dict[str, Any]:
    data = message.get("text")
    return decode_command(message.get("bytes") or b"" if data is None else data)


def _take(session: SessionHost, client: Client, command: dict[str, Any], following: Following | None) -> None:
    match command["type"]:
        case "ack":
            session.acknowledge(client, integer(command, "seq"))
        case "resume":
            if text(command, "epoch_id") == session.epoch_id:
                client.resume(text(command, "layer"), integer(command, "epoch"), integer(command, "revision"))
        case "subscribe":
            client.subscribe(command["layers"])
        case "ping":
            client.send({"type": "pong", "id": integer(command, "id"), "t": session.hub.clock()})
        case kind if following is not None and kind != "inspect" and not following.may(kind):
            raise ProtocolError("class.read_only", "The lecturer drives this robot; your own world obeys you.")
        case _:
            session.enqueue(command, client)
