"""Malicious uploads: each fails alone, with its own error, and leaves no file."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import hashlib
import socket
import threading
import zlib
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager, ExitStack
from typing import Any

import httpx
import pytest

from server.library.logs.sample import SAMPLE_ID
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, Watcher, once_read, until

Undisturbed = Callable[[Service], AbstractAsyncContextManager[Watcher]]
LINE = b"FLASER 4 1.0 2.0 3.0 4.0 0.1 0.2 0.3 0.1 0.2 0.3 12.5 host 12.5\n"


def bomb(unit: bytes, megabytes: int, before: bytes = LINE) -> bytes:
    """A gzip file that grows a thousandfold."""
    packer = zlib.compressobj(9, wbits=31)
    block = unit * ((1 << 20) // len(unit))
    return packer.compress(before) + b"".join(packer.compress(block) for _ in range(megabytes)) + packer.flush()


def far_apart() -> bytes:
    """A log whose poses are places, and whose map would be as large as a country."""
    return b"".join(LINE.replace(b"0.1 0.2 0.3", b"%d 0 0" % (450_000 * (-1) ** n)) for n in range(6))


def bad_logs() -> dict[str, tuple[bytes, str]]:
    """Logs by what is the matter with them, and the code of the error of each; packing the bombs takes seconds."""
    zeros = bomb(b"\0", 300)
    return {
        "a bomb of zeros": (zeros, "log.line_too_long"),
        "a bomb of zeros alone": (bomb(b"\0", 300, b""), "log.binary"),
        "a bomb of empty lines": (bomb(b"\n", 20), "log.too_many_lines"),
        "a bomb in a bomb": (gzip.compress(zeros), "log.unknown_format"),
        "a line of 20 MB": (LINE + b"FLASER 1 " + b"1 " * 10_000_000, "log.line_too_long"),
        "a gzip file cut in its header": (gzip.compress(LINE)[:9], "log.truncated"),
        "a text file cut in its first line": (LINE[:30], "log.truncated_line"),
        "garbage": (bytes(range(256)) * 100, "log.binary"),
        "another program's archive": (b"PK\x03\x04" + bytes(100), "log.archive"),
        "no scans": (b"ODOM 0.1 0.2 0.3 0 0 0 12.4 host 12.4\n", "log.no_scans"),
        "a pose of nan": (LINE + LINE.replace(b"0.1", b"nan", 1), "log.pose"),
        "a pose of 1e308": (LINE + LINE.replace(b"0.1", b"1e308", 1), "log.pose"),
        "a reading of 1e999": (LINE.replace(b"3.0", b"1e999"), "log.not_a_number"),
        "more beams than there are": (LINE.replace(b"FLASER 4", b"FLASER 180"), "log.beam_count"),
        "minus four beams": (LINE.replace(b"FLASER 4", b"FLASER -4"), "log.beam_count"),
        "a billion beams": (LINE.replace(b"FLASER 4", b"FLASER 1000000000"), "log.beam_count"),
    }


def sent(service: Service, data: bytes, name: str = "a.log") -> dict[str, Any]:
    """Upload a log; return what the service says of it once it was read."""
    answer = service.http.put("/api/logs", params={"name": name}, content=data)
    assert answer.status_code == 202, answer.text
    return once_read(service.http, answer.json()["id"])


def open_log(service: Service, log: dict[str, Any]) -> httpx.Response:
    return service.http.post("/api/sessions", json={"kind": "log", "log": log["id"]})


def left(service: Service) -> list[str]:
    """Files of uploads, packs and pictures, without those of the service's own sample."""
    folder = service.state.settings.data_dir / "library"
    found = [str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()]
    return [name for name in found if not name.startswith("library.db") and SAMPLE_ID not in name]


async def test_each_bad_log_fails_alone_with_its_own_error(service: Service, undisturbed: Undisturbed) -> None:
    logs = bad_logs()  # before the watcher: it acknowledges frames on this event loop, within 30 s
    async with undisturbed(service):
        for case, (data, code) in logs.items():
            log = await asyncio.to_thread(sent, service, data)
            assert (log["state"], (log["error"] or {}).get("code")) == ("failed", code), case
            assert log["error"]["message"].endswith(".")
            assert not [
                part for part in ("/", "Traceback") if part in log["error"]["message"].replace("http://", "")
            ], case
            opened = await asyncio.to_thread(open_log, service, log)
            assert (opened.status_code, opened.json()["code"]) == (422, code)
            assert (await asyncio.to_thread(service.http.delete, f"/api/logs/{log['id']}")).status_code == 204
    assert left(service) == []


@pytest.mark.parametrize("reading", [b"nan", b"-3.0", b"-1e308", b"1e308", b"0"])
async def test_impossible_readings_are_no_evidence(service: Service, reading: bytes) -> None:
    """The log is read all the same; such a beam leaves no mark in the map."""
    maps = []
    for third in (reading, b"inf"):
        log = await asyncio.to_thread(sent, service, LINE.replace(b"3.0", third) * 3)
        assert log["state"] == "ready", log
        session_id = (await asyncio.to_thread(open_log, service, log)).json()["id"]
        async with service.connect(session_id) as socket:
            watcher = Watcher(socket)
            await watcher.send("seek", index=3)
            await watcher.until(lambda watcher=watcher: watcher.newest.get("frame", {}).get("index") == 3)  # type: ignore[misc]
            await watcher.settle()
            assert watcher.newest["frame"]["ranges"] == [1.0, 2.0, None, 4.0]
        maps.append((await asyncio.to_thread(service.http.get, f"/api/sessions/{session_id}/map.pgm")).content)
        await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")
        await asyncio.to_thread(service.http.delete, f"/api/logs/{log['id']}")
    assert maps[0] == maps[1]


async def test_a_log_whose_map_is_too_large_is_read_and_not_opened(service: Service, undisturbed: Undisturbed) -> None:
    async with undisturbed(service):
        log = await asyncio.to_thread(sent, service, far_apart())
        assert log["state"] == "ready"
        opened = await asyncio.to_thread(open_log, service, log)
        assert (opened.status_code, opened.json()["code"]) == (413, "grid.too_large")
        await asyncio.to_thread(service.http.delete, f"/api/logs/{log['id']}")


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("../../../etc/passwd", "passwd"),
        ("..\\..\\boot.ini", "boot.ini"),
        ("a\0b.log", "ab.log"),
        ("\u202egol.exe", "gol.exe"),
        ("one\r\nSet-Cookie: a=b", "one Set-Cookie: a=b"),
        ("..", "log"),
        ("", "log"),
        ("<img src=x onerror=alert(1)>", "<img src=x onerror=alert(1)>"),  # shown as text: the page makes no HTML of it
        ("x" * 900, "x" * 119 + "…"),
    ],
)
def test_a_name_is_only_shown(service: Service, name: str, shown: str) -> None:
    log = sent(service, carmen(3), name)
    assert (log["state"], log["name"]) == ("ready", shown)
    digest = hashlib.sha256(carmen(3)).hexdigest()
    assert sorted(left(service)) == [f"blobs/{digest}", f"packs/{log['id']}.npz", f"pictures/{log['id']}.png"]
    service.http.delete(f"/api/logs/{log['id']}")


def test_a_name_of_four_thousand_letters_is_refused(service: Service) -> None:
    answer = service.http.put("/api/logs", params={"name": "x" * 4096}, content=LINE)
    assert (answer.status_code, answer.json()["code"]) == (422, "request.invalid")
    assert left(service) == []


def test_eight_uploads_that_trickle_keep_no_honest_one_out(service: Service) -> None:
    """At 300 bytes a second from one address, under the cookies of two visitors."""
    total = 1_000_000
    ended = threading.Event()
    with ExitStack() as held:
        slow = [
            held.enter_context(socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S))
            for _ in range(8)
        ]
        for number, connection in enumerate(slow):
            connection.sendall(
                f"PUT /api/logs?name=slow&upload={number:020} HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n"
                f"Cookie: gridbloom_visitor={number // 4:024}\r\nContent-Length: {total}\r\n"
                f"Content-Range: bytes 0-{total - 1}/{total}\r\n\r\n".encode()
            )
        slots = service.state.library._slots
        until(lambda: len(slots) == 8)

        def trickle() -> None:
            while not ended.wait(0.1):
                for connection in slow:
                    with contextlib.suppress(OSError):
                        connection.send(b"x" * 30)

        sender = threading.Thread(target=trickle)
        sender.start()
        try:
            assert sent(service, carmen(20))["state"] == "ready"
        finally:
            ended.set()
            sender.join()
        offsets = []
        for number, connection in enumerate(slow):
            connection.settimeout(0.05)
            with contextlib.suppress(TimeoutError):
                answer = connection.recv(1000)
                assert answer.startswith(b"HTTP/1.1 503")
                assert b"library.busy" in answer
                offsets.append(
                    httpx.get(
                        f"http://127.0.0.1:{service.port}/api/logs/uploads/{number:020}",
                        cookies={"gridbloom_visitor": f"{number // 4:024}"},
                        timeout=PATIENCE_S,
                    ).json()["offset"]
                )
        assert len(offsets) == 1, "one of them made room"
        assert offsets[0] > 0, "its sender may go on with it"
    until(lambda: len(slots) == 0)
