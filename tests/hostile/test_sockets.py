"""Sockets that break the protocol: their client gets an error or is disconnected, and no other one is affected."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import struct
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from mapper.core.parameter import Parameter
from mapper.mapping.parameters import PARAMETERS
from mapper.simulation import SENSOR_PARAMETERS
from server.serving import listen
from tests.server.service import PATIENCE_S, Service, Watcher, eventually, running, settings_for, until_closed

Undisturbed = Callable[[Service], AbstractAsyncContextManager[Watcher]]

ODD: tuple[Any, ...] = (
    *(None, True, -1, 1.5, 1e308, -1e308, 2**53, 2**70, 10**400),
    *("", "x" * 20_000, "\0", "\ud800", "<script>", [], [1], {}, {"a": 1}),
)
COMMANDS: dict[str, dict[str, Any]] = {
    "ack": {"seq": 0},
    "resume": {"epoch_id": "x", "layer": "map", "epoch": 1, "revision": 0},
    "subscribe": {"layers": ["map", "second_map"]},
    "step": {"scans": 1},
    "speed": {"value": 1.0},
    "seek": {"index": 0},
    "parameters": {"values": {}},
    "teleport": {"x": 2.0, "y": 2.0, "yaw": 0.0},
    "drive": {"linear": 0.1, "angular": 0.1},
    "auto": {"value": True},
    "edit": {"added": [["box", 300, 300, 340, 360]], "erased": []},
    "faults": {"values": {"drift": True}},
    "compare": {"values": {"clamp": False}},
    "world": {"name": "room"},
    "sensor": {"values": {}},
    "trajectory": {"name": "true"},
    "inspect": {"row": 0, "col": 0, "epoch": 1},
    "why": {"row": 0, "col": 0, "epoch": 1, "until": 1},
    "ping": {"id": 1},
    "conquer": {"world": "room"},
    "": {},
}


def frame(opcode: int, data: bytes, *, fin: bool = True, masked: bool = True, length: int | None = None) -> bytes:
    """A frame of RFC 6455, or one that says it is."""
    length = len(data) if length is None else length
    mask = 0x80 if masked else 0
    if length < 126:
        size = struct.pack(">B", mask | length)
    elif length < 1 << 16:
        size = struct.pack(">BH", mask | 126, length)
    else:
        size = struct.pack(">BQ", mask | 127, length)
    return bytes([(0x80 if fin else 0) | opcode]) + size + (b"\0\0\0\0" if masked else b"") + data


def open_raw(service: Service, session_id: str, receive_buffer: int | None = None) -> socket.socket:
    """A socket after its handshake."""
    connection = socket.socket()
    if receive_buffer is not None:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    connection.settimeout(PATIENCE_S)
    connection.connect(("127.0.0.1", service.port))
    connection.sendall(
        f"GET /api/sessions/{session_id}/stream HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n".encode()
        + b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        + b"Sec-WebSocket-Protocol: gridbloom.v3\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    )
    answer = b""
    while b"\r\n\r\n" not in answer:
        answer += connection.recv(1)
    assert answer.startswith(b"HTTP/1.1 101")
    return connection


def close_code(connection: socket.socket) -> int | None:
    """Read frames until the service closes; return the code it gives, None for none."""
    data = b""
    with contextlib.suppress(ConnectionError):
        while part := connection.recv(65536):
            data += part
    while data:
        opcode, length, at = data[0] & 15, data[1], 2
        if length == 126:
            length, at = struct.unpack_from(">H", data, 2)[0], 4
        elif length == 127:
            length, at = struct.unpack_from(">Q", data, 2)[0], 10
        if opcode == 8:
            return int.from_bytes(data[at : at + 2], "big")
        data = data[at + length :]
    return None


BROKEN = {
    "text that is no UTF-8": (frame(1, b"\xff\xfe"), 1007),
    "a frame without a mask": (frame(1, b"{}", masked=False), 1002),
    "reserved bits": (frame(0x71, b""), 1002),
    "an opcode that there is not": (frame(3, b""), 1002),
    "a frame of eight exabytes": (frame(1, b"", length=2**63 - 1), 1009),
    "a long ping": (frame(9, b"x" * 126), 1002),
    "a close of one byte": (frame(8, b"x"), 1002),
    "a close that is no UTF-8": (frame(8, b"\x03\xe8\xff"), 1007),
    "the rest of nothing": (frame(0, b"x"), 1002),
    "a beginning after a beginning": (frame(1, b"{", fin=False) * 2, 1002),
    "a message in parts without end": (
        frame(1, b"x" * 60_000, fin=False) + frame(0, b"x" * 60_000, fin=False) * 30, 1009
    ),
    "an HTTP request": (b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", 1002),
}  # fmt: skip


async def test_a_broken_websocket_is_closed(service: Service, undisturbed: Undisturbed) -> None:
    async with undisturbed(service):
        session_id = await asyncio.to_thread(service.begin)
        for case, (data, code) in BROKEN.items():
            with await asyncio.to_thread(open_raw, service, session_id) as connection:
                with contextlib.suppress(ConnectionError):  # closed before all of it was read
                    connection.sendall(data)
                assert await asyncio.to_thread(close_code, connection) in (code, None), case
        session = service.state.sessions.get(session_id)
        await eventually(lambda: not session.watched)


async def test_pings_and_empty_parts_without_end_cost_only_their_sender(
    service: Service, undisturbed: Undisturbed
) -> None:
    session_id = await asyncio.to_thread(service.begin)
    async with undisturbed(service):
        with await asyncio.to_thread(open_raw, service, session_id) as connection:
            for data in (
                frame(9, b"x" * 100) * 3000,
                frame(10, b"x") * 3000,
                frame(1, b"", fin=False) + frame(0, b"") * 1,
            ):
                await asyncio.to_thread(connection.sendall, data)


@pytest.fixture
def unthrottled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands as fast as they come: how many a client may send is not the matter here."""
    monkeypatch.setattr("server.http.stream_connection.COMMAND_BURST", 1e9)
    monkeypatch.setattr("server.http.stream_connection.MAX_MALFORMED", 10**9)


async def barrier(watcher: Watcher, number: int) -> None:
    """Wait until what was sent so far was taken in."""
    await watcher.send("ping", id=number)
    await watcher.until(lambda: watcher.newest.get("pong", {}).get("id") == number)


@pytest.mark.usefixtures("unthrottled")
@pytest.mark.parametrize("kind", ["simulation", "log"])
async def test_every_command_handles_odd_values(service: Service, undisturbed: Undisturbed, kind: str) -> None:
    wanted = {"kind": "log", "log": "sample-office"} if kind == "log" else {"kind": "simulation", "world": "room"}
    session_id = await asyncio.to_thread(lambda: service.begin(**wanted))
    async with undisturbed(service), service.connect(session_id) as socket:
        watcher = Watcher(socket)
        count = 0
        for name, good in COMMANDS.items():
            await watcher.send(name)
            for key in good:
                for odd in ODD:
                    await socket.send(json.dumps({"type": name} | good | {key: odd}))
                count += 1
                await barrier(watcher, count)
        session = service.state.sessions.get(session_id)
        await eventually(lambda: not session.has_queued_commands)
        await watcher.send("subscribe", layers=["map"])  # one of the odd values is a list, without a layer
        await watcher.send("play")
        frames = watcher.frames
        await watcher.until(lambda: watcher.frames > frames + 3)
        said = [m for m in watcher.messages if m["type"] in ("error", "notice")]
        assert len(said) > 100
        assert "internal" not in {m["code"] for m in said}
        assert max(len(m["message"]) for m in said) < 300


def odd_values(row: Parameter) -> list[tuple[Any, bool]]:
    """Values of a parameter, and whether each is allowed."""
    if row.kind == "flag":
        return [(True, True), (False, True), (1, False), ("true", False), (None, False)]
    if row.kind == "choice":
        return [*((choice, True) for choice in row.choices), ("x", False), (0, False), (None, False), ([], False)]
    allowed = [(row.low, True), (row.high, True)]
    beyond: list[Any] = [row.low - 1, row.high + 1, 1e308, -1e308, 10**400, -(10**400)]
    return [*allowed, *((v, False) for v in [*beyond, "1", True, None, [row.low], {}])]


@pytest.mark.usefixtures("unthrottled")
@pytest.mark.parametrize("command", ["parameters", "sensor"])
async def test_every_parameter_at_its_bounds_and_beyond(
    service: Service, undisturbed: Undisturbed, command: str
) -> None:
    rows = PARAMETERS if command == "parameters" else SENSOR_PARAMETERS
    session_id = await asyncio.to_thread(service.begin)
    async with undisturbed(service), service.connect(session_id) as socket:
        watcher = Watcher(socket)
        for number, row in enumerate(rows):
            seen = len(watcher.messages)
            for value, _ in odd_values(row):
                await watcher.send(command, values={row.name: value})
            await watcher.send(command, values={row.name: row.initial})
            await watcher.send("speed", value=0)  # refused after all that came before it
            await watcher.until(lambda seen=seen: "command.value" in codes(watcher, seen))  # type: ignore[misc]
            refused = [code for code in codes(watcher, seen) if code != "command.value"]
            # Two of the bounds concern two parameters at once: such a pair is refused by another name.
            assert refused.count(f"parameter.{row.name}") == sum(not good for _, good in odd_values(row))
            assert set(refused) <= {f"parameter.{row.name}", "parameter.clamp", "model.probabilities"}
            await barrier(watcher, number)


def codes(watcher: Watcher, since: int) -> list[str]:
    return [m["code"] for m in watcher.messages[since:] if m["type"] == "error"]


@pytest.mark.usefixtures("unthrottled")
async def test_the_largest_requested_map_stays_within_its_cells(tmp_path: Path) -> None:
    """Every parameter that makes a map large, at its largest, in a service that allows few cells."""
    with running(settings_for(tmp_path, max_cells=1 << 20)) as service:
        session_id = service.begin(kind="simulation", world="office", seed=1)
        async with service.connect(session_id) as socket:
            watcher = Watcher(socket)
            await watcher.send("parameters", values={"resolution": 0.01, "range_max": 100.0, "no_return": "free"})
            error = await watcher.answer("error")
            assert error["code"] == "grid.too_large"
            frames = watcher.frames
            await watcher.until(lambda: watcher.frames > frames + 3)
            assert service.state.sessions.get(session_id).cells <= 1 << 20


async def test_a_client_that_never_reads_is_disconnected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page that is frozen with full buffers would keep its session alive, and its place, for ever."""
    monkeypatch.setattr("server.serving.UNREAD_MS", 500)

    def with_small_buffers(host: str, port: int) -> socket.socket:
        bound = listen(host, port)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        return bound

    monkeypatch.setattr("tests.server.service.listen", with_small_buffers)
    with running(settings_for(tmp_path)) as service:
        session_id = await asyncio.to_thread(lambda: service.begin(kind="log", log="sample-office"))
        session = service.state.sessions.get(session_id)
        with open_raw(service, session_id, receive_buffer=4096) as connection:
            await eventually(lambda: session.watched)
            connection.settimeout(0.1)
            with contextlib.suppress(OSError):
                for number in range(100):
                    name = ("true", "odometry")[number % 2]
                    connection.sendall(frame(1, json.dumps({"type": "trajectory", "name": name}).encode()))
                    await asyncio.sleep(0.02)
            await eventually(lambda: not session.watched)


async def test_no_more_browsers_than_allowed_watch_a_session(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, max_clients_per_session=3)) as service:
        session_id = service.begin()
        connections = [open_raw(service, session_id) for _ in range(3)]
        session = service.state.sessions.get(session_id)
        await eventually(lambda: len(session.hub.clients) == 3)
        async with service.connect(session_id) as fourth:
            await until_closed(fourth)
            assert (fourth.close_code, fourth.close_reason) == (4404, "session.crowded")
        for connection in connections:
            connection.close()
        await eventually(lambda: not session.watched)
        async with service.connect(session_id) as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: watcher.frames > 2)


async def test_a_session_that_ends_while_many_steer_it(service: Service, undisturbed: Undisturbed) -> None:
    """Ends race with commands and new watchers: whoever is late hears that the session has ended or is not there."""
    async with undisturbed(service):
        for _ in range(5):
            session_id = await asyncio.to_thread(service.begin)

            async def steer(session_id: str = session_id) -> tuple[int | None, str | None]:
                async with service.connect(session_id) as socket:
                    with contextlib.suppress(ConnectionClosed):
                        while True:
                            await socket.send('{"type":"teleport","x":2,"y":2}')
                            await socket.recv()
                    return socket.close_code, socket.close_reason

            steering = [asyncio.create_task(steer()) for _ in range(6)]
            await asyncio.sleep(0.05)
            ends = await asyncio.gather(
                *(asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}") for _ in range(3))
            )
            assert min(end.status_code for end in ends) == 204
            assert {end.status_code for end in ends} <= {204, 404}
            assert {code for code, _ in await asyncio.gather(*steering)} <= {4410, 4404}
