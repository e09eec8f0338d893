"""The exchange of messages between one page and a class; see :mod:`server.stream.class_messages`."""

from __future__ import annotations

import asyncio
import contextlib

import msgspec
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from mapper.core.errors import MapperError
from server.classes import Classroom, Member
from server.http.stream_connection import accepted, command_allowance
from server.stream.class_messages import ClassCommand, ClassError
from server.stream.close_codes import ENDED, POLICY, RESTARTING

MAX_BYTES = 256 * 1024  #: of a message, because an explanation of a cell has up to 300 updates
MAX_REFUSED = 50  #: refused commands after which the socket is closed

_decoder = msgspec.json.Decoder(ClassCommand)


async def attend(websocket: WebSocket, room: Classroom, member: Member) -> None:
    """Accept the WebSocket of a class member, and exchange messages until it ends."""
    try:
        if not await accepted(websocket):
            return
        tasks = [
            asyncio.create_task(_send(websocket, room, member), name="class out"),
            asyncio.create_task(_receive(websocket, room, member), name="class in"),
        ]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
    finally:
        room.leave(member)


async def _send(websocket: WebSocket, room: Classroom, member: Member) -> None:
    while True:
        member.wake.clear()
        for message in room.take(member):
            await websocket.send_text(message)
        if room.has_ended:
            await _close(websocket, ENDED.code, "class.ended")
            return
        if room.has_moved:
            await _close(websocket, RESTARTING.code, "class.moved")
            return
        await member.wake.wait()


async def _receive(websocket: WebSocket, room: Classroom, member: Member) -> None:
    refused = 0
    allowance = command_allowance()
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return
        text = message.get("text")
        try:
            if text is None or len(text) > MAX_BYTES:
                raise msgspec.ValidationError(f"A message is a text of at most {MAX_BYTES} characters")
            room.handle(member, _decoder.decode(text))
        except MapperError as error:
            member.send(ClassError(error.code, error.message, room.counted_answer(member)))
            refused += 1
        except (msgspec.DecodeError, RecursionError) as error:
            member.send(ClassError("class.command", f"{error}."))
            refused += 1
        if refused > MAX_REFUSED:
            await _close(websocket, POLICY.code, "too many refused commands")
            return
        await asyncio.sleep(allowance.spend())


async def _close(websocket: WebSocket, code: int, reason: str) -> None:
    if websocket.application_state is WebSocketState.CONNECTED:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            await websocket.close(code, reason)
