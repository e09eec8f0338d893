"""The exchange of messages between one browser and a session; see :mod:`server.stream.protocol`."""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import structlog
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from server.parts.why.messages import InspectCommand
from server.parts.wire import Command, decode_command
from server.sessions import SessionBudgetError, SessionHost
from server.stream.close_codes import ENDED, INTERNAL, NO_ACKS, POLICY, CloseCode
from server.stream.commands import (
    AckCommand,
    MeasureCommand,
    PingCommand,
    ResumeCommand,
    SelectCommand,
    SubscribeCommand,
)
from server.stream.frames import EXTENSION, DirectSocket, binary_frame
from server.stream.hub import Client
from server.stream.messages import ErrorMessage, ForeignHello, Pong
from server.stream.protocol import SUBPROTOCOL, ProtocolError, encode_text, type_of
from server.work.movable_timer import MovableTimer
from server.work.token_bucket import TokenBucket

MAX_MALFORMED = 20  #: invalid frames after which the socket is closed
COMMANDS_PER_S, COMMAND_BURST = 120.0, 240.0
LEAVING_S = 1.0  #: time for pages to leave a session that their class no longer shows
_ACKNOWLEDGEMENT = re.compile(rb'\{"type": ?"ack", ?"seq": ?([0-9]{1,10})\}')
MAX_THROTTLED = 1200  #: commands above the rate after which the socket is closed; reset after a rest

_log = structlog.get_logger(__name__)


def command_allowance() -> TokenBucket:
    """Return the limit for the commands of one client. Above the rate they are read more slowly."""
    return TokenBucket(COMMAND_BURST, COMMANDS_PER_S)


@dataclass(frozen=True, slots=True)
class Following:
    """A client that follows the lecturer of a class. It sees the session, and its commands are refused.

    ``may`` says whether a command of that type is allowed nevertheless. ``over`` is set once the class no longer shows
    the session, which ends the connection.
    """

    may: Callable[[str], bool]
    over: asyncio.Event


def speaks(websocket: WebSocket) -> bool:
    """Return whether a page uses this version of the protocol."""
    return SUBPROTOCOL in websocket.scope["subprotocols"]


async def accepted(websocket: WebSocket) -> bool:
    """Accept the WebSocket of a page of this version; make other pages request a reload."""
    if speaks(websocket):
        await websocket.accept(subprotocol=SUBPROTOCOL)
        return True
    # A browser accepts only a subprotocol that the page has offered.
    offered: list[str] = websocket.scope["subprotocols"]
    other = next((name for name in offered if name.startswith("gridbloom.")), None)
    await websocket.accept(subprotocol=other)
    if other is not None:
        await websocket.send_text(encode_text(ForeignHello(SUBPROTOCOL)))
    await websocket.close(POLICY.code, f"the subprotocol {SUBPROTOCOL} is required")
    return False


async def exchange(
    websocket: WebSocket, session: SessionHost, max_clients: int, following: Following | None = None, *, page: str = ""
) -> None:
    """Accept the WebSocket of a page and exchange messages until it ends, if fewer than ``max_clients`` have joined.

    Followers of a class are counted separately. Raises :class:`SessionBudgetError` before the socket is accepted.
    """
    if not speaks(websocket):
        await accepted(websocket)
        return
    follows = following is not None
    if sum(client.follows == follows for client in session.hub.clients) >= max_clients:
        raise SessionBudgetError("session.crowded", "Too many browsers watch this session already.")
    await accepted(websocket)
    client = session.join(follows=follows, page=page)
    allowance = command_allowance()
    direct: DirectSocket | None = websocket.scope.get("extensions", {}).get(EXTENSION, {}).get("socket")
    if direct is not None:
        direct.on_text = partial(_take_acknowledgement, session, client, allowance)
    tasks = [
        asyncio.create_task(_send(websocket, session, client, direct), name="stream out"),
        asyncio.create_task(_receive(websocket, session, client, following, allowance), name="stream in"),
    ]
    if following is not None:
        tasks.append(asyncio.create_task(_leave(following.over), name="session of a class"))
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        if direct is not None:
            direct.on_text = None
        session.leave(client)
        for task in tasks:
            task.cancel()
        done = await asyncio.gather(*tasks, return_exceptions=True)
        is_closed = websocket.application_state is WebSocketState.DISCONNECTED
        for result in done:
            if isinstance(result, RuntimeError) and is_closed:  # one task sent after the other had closed it
                continue
            if isinstance(result, Exception) and not isinstance(result, WebSocketDisconnect):
                _log.error("a stream failed", exc_info=result)
                await _close(websocket, INTERNAL, "internal")
        if following is not None and following.over.is_set():
            await _close(websocket, ENDED, "class.not_shown")


async def _leave(over: asyncio.Event) -> None:
    """Return shortly after ``over``: the page learns of it from the class and ends the connection without an error."""
    await over.wait()
    await asyncio.sleep(LEAVING_S)


async def _close(websocket: WebSocket, code: CloseCode, reason: str) -> None:
    if websocket.application_state is WebSocketState.CONNECTED:
        # The browser may have disconnected in the meantime.
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await websocket.close(code.code, reason)


async def _send(websocket: WebSocket, session: SessionHost, client: Client, direct: DirectSocket | None) -> None:
    outgoing = None if direct is None else Outgoing(session, client, direct)
    try:
        while True:
            client.wake.clear()
            messages = _messages(session, client)
            if direct is not None and messages:
                await websocket.send({"type": "websocket.send", "frames": _frames(session, messages)})
            else:
                for message in messages:
                    await (
                        websocket.send_bytes(message) if isinstance(message, bytes) else websocket.send_text(message)
                    )
            if session.closed:
                await _close(websocket, ENDED, "session.ended")
                return
            if client.is_lost:
                await _close(websocket, NO_ACKS, "no frame was acknowledged for a long time")
                return
            if outgoing is None:
                await _set_within(client.wake, client.wait_s())
            else:
                await outgoing.run()
    finally:
        if outgoing is not None:
            outgoing.close()


class Outgoing:
    """Sends the messages for one client immediately, without waking a task, which would cost more than sending.

    Everything else is left to the task that waits for :meth:`run`: the session's end, and a client that reads slowly.
    """

    def __init__(self, session: SessionHost, client: Client, direct: DirectSocket) -> None:
        self._session, self._client, self._direct = session, client, direct
        self._loop = asyncio.get_running_loop()
        self._is_running = self._is_scheduled = False
        self._timer = MovableTimer(self._schedule)
        client.on_wake = self._schedule

    async def run(self) -> None:
        """Send until something happens that only the task can handle."""
        self._is_running = True
        self._arm()
        if self._client.wake.is_set():  # since the task last checked
            self._schedule()
        self._client.wake.clear()
        try:
            await self._client.wake.wait()
        finally:
            self._is_running = False

    def close(self) -> None:
        """Stop sending."""
        self._client.on_wake = self._client.wake.set
        self._timer.close()

    def _schedule(self) -> None:
        if not self._is_running:
            self._client.wake.set()
        elif not self._is_scheduled:
            self._is_scheduled = True
            self._loop.call_soon(self._send)

    def _send(self) -> None:
        self._is_scheduled = False
        client, session = self._client, self._session
        if not self._is_running or session.closed or client.is_lost or not self._direct.is_ready():
            client.wake.set()
            return
        try:
            messages = _messages(session, client)
            if messages:
                self._direct.write(_frames(session, messages))
            self._arm()
        except BaseException:  # the task gets it too, and ends the connection
            client.wake.set()
            raise

    def _arm(self) -> None:
        """Check again no later than the client requires."""
        self._timer.set_in(self._client.wait_s())


def _messages(session: SessionHost, client: Client) -> list[str | bytes]:
    messages = client.take()
    # Anyone with the id of a session can control it.
    return [_without_id(message, session.id) for message in messages] if client.follows else messages


def _frames(session: SessionHost, messages: list[str | bytes]) -> bytes:
    """Return messages as the frames of a WebSocket."""
    return b"".join(
        [
            binary_frame((message,)) if isinstance(message, bytes) else session.hub.text_frame(message)
            for message in messages
        ]
    )


def _without_id(message: str | bytes, session_id: str) -> str | bytes:
    if isinstance(message, str) and message.startswith('{"type":"hello"'):
        return message.replace(session_id, "")
    return message


def _take_acknowledgement(session: SessionHost, client: Client, allowance: TokenBucket, data: bytes) -> bool:
    """Handle an acknowledgement, the most frequent command, without waking a task; return whether it was one."""
    match = _ACKNOWLEDGEMENT.fullmatch(data)
    if match is None or not allowance.try_to_spend():
        return False
    try:
        session.acknowledge(client, int(match[1]))
    except ProtocolError:  # the task answers it
        return False
    return True


async def _receive(
    websocket: WebSocket, session: SessionHost, client: Client, following: Following | None, allowance: TokenBucket
) -> None:
    malformed = throttled = 0
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return
        try:
            _take(session, client, _decode(message), following)
        except ProtocolError as error:
            client.send(ErrorMessage(error.code, error.message))
            malformed += error.code.startswith("command.")
            if malformed > MAX_MALFORMED:
                await _close(websocket, POLICY, "too many malformed frames")
                return
        wait = allowance.spend()
        # A busy service reads more slowly, so a command without a wait does not mean that the flood is over.
        throttled = 0 if allowance.has_rested else throttled + (wait > 0.0)
        if throttled > MAX_THROTTLED:
            await _close(websocket, POLICY, "too many commands")
            return
        if wait > 0.0:  # the allowance also limits how many commands are read in one pass of the event loop
            await asyncio.sleep(wait)


def _decode(message: MutableMapping[str, Any]) -> Command:
    data = message.get("text")
    return decode_command(message.get("bytes") or b"" if data is None else data)


def _take(session: SessionHost, client: Client, command: Command, following: Following | None) -> None:
    match command:
        case AckCommand(seq=seq):
            session.acknowledge(client, seq)
        case ResumeCommand():
            if command.epoch_id == session.epoch_id:
                client.resume(command.layer, command.epoch, command.revision)
        case SubscribeCommand(layers=layers):
            client.subscribe(layers)
        case SelectCommand(place=place):
            session.select(client, place)
        case MeasureCommand():
            session.measure(client, command)
        case PingCommand(id=number):
            client.send(Pong(number, session.hub.clock()))
        case InspectCommand():
            session.enqueue(command, client)
        case _ if following is not None and not following.may(type_of(command)):
            raise ProtocolError("class.read_only", "The lecturer drives this robot; you can drive it in your own copy.")
        case _:
            session.enqueue(command, client)


async def _set_within(event: asyncio.Event, seconds: float | None) -> None:
    """Wait until ``event`` is set, which also happens after ``seconds`` (None: never).

    It costs half as much as ``asyncio.timeout``, which matters if hundreds of clients wait for each tick.
    """
    timer = None if seconds is None else asyncio.get_running_loop().call_later(seconds, event.set)
    try:
        await event.wait()
    finally:
        if timer is not None:
            timer.cancel()
