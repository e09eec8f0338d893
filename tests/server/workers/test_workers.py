"""A service of several worker processes behind one port, as the command runs it."""

from __future__ import annotations

import asyncio
import binascii
import contextlib
import http.client
import json
import os
import signal
import socket
import sqlite3
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families

from server.classes.classes import new_code, normalised
from server.workers.places import worker_of_class
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, once_read, stream_at, until

SERVE = [sys.executable, "-c", "from server.cli import main; main()", "serve", "--port", "0", "--workers", "2"]
WORLD = {"kind": "simulation", "world": "room", "seed": 3}


class Workers:
    """A running service: its supervisor and its port."""

    def __init__(self, process: subprocess.Popen[str], port: int) -> None:
        self.process, self.port = process, port
        self.address = f"http://127.0.0.1:{port}"
        self._taken: set[str] = set()

    def workers(self) -> set[int]:
        """The processes of the workers."""
        return set(self.numbered())

    def numbered(self) -> list[int]:
        """The processes of the workers in the order of their start: by number, as long as none was replaced."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return list(map(int, children))

    def visitor_of(self, worker: int) -> httpx.Client:
        """A browser that this worker serves, by its cookie."""
        names = (f"{n:024}" for n in count(1))
        name = next(one for one in names if binascii.crc32(one.encode()) % 2 == worker and one not in self._taken)
        self._taken.add(name)
        return httpx.Client(base_url=self.address, timeout=PATIENCE_S, cookies={"gridbloom_visitor": name})


@contextlib.contextmanager
def serving(folder: Path, **environment: str) -> Iterator[Workers]:
    command = [*SERVE, "--data-dir", str(folder)]
    given = {"GRIDBLOOM_COMPILE_AHEAD": "false"} | environment
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | given)
    assert process.stdout is not None
    try:
        port = int(process.stdout.readline().rsplit(":", 1)[1].strip("/\n"))
        running = Workers(process, port)
        until(lambda: len(running.workers()) == 2)
        yield running
    finally:
        process.terminate()
        try:
            status = process.wait(PATIENCE_S)
        finally:
            process.kill()
            process.stdout.close()
    assert status in (0, -signal.SIGKILL)  # unless the test has killed it


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workers]:
    with serving(tmp_path_factory.mktemp("workers"), GRIDBLOOM_MAX_SESSIONS="6") as running:
        yield running


@pytest.fixture
def pair(service: Workers) -> Iterator[tuple[httpx.Client, httpx.Client]]:
    """A visitor of each worker, with a session of its own, which ends with the test."""
    with service.visitor_of(0) as first, service.visitor_of(1) as second:
        for visitor in (first, second):
            visitor.post("/api/sessions", json=WORLD).raise_for_status()
        yield first, second
        for visitor in (first, second):
            for session in sessions_of(visitor):
                visitor.delete(f"/api/sessions/{session}")


def sessions_of(visitor: httpx.Client) -> list[str]:
    return [one["id"] for one in visitor.get("/api/sessions").raise_for_status().json()["sessions"]]


def counted(service: Workers, name: str) -> float:
    text = httpx.get(f"{service.address}/metrics", timeout=PATIENCE_S).raise_for_status().text
    return sum(
        sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
        if sample.name == name
    )


async def shows_a_frame(address: str) -> bool:
    async with asyncio.timeout(PATIENCE_S), stream_at(address) as socket:
        async for message in socket:
            if isinstance(message, str) and json.loads(message)["type"] == "frame":
                return True
    return False


def test_one_connection_reaches_the_sessions_of_both_in_turn(service: Workers, pair: Any) -> None:
    ids = [sessions_of(visitor)[0] for visitor in pair]
    assert [session[:2] for session in ids] == ["0.", "1."]
    connection = http.client.HTTPConnection("127.0.0.1", service.port, timeout=PATIENCE_S)
    local = None
    for session in [*ids, *ids, ids[0]]:
        connection.request("GET", f"/api/sessions/{session}")
        answer = connection.getresponse()
        assert (answer.status, json.loads(answer.read())["id"]) == (200, session)
        local = local or connection.sock.getsockname()
        assert connection.sock.getsockname() == local  # it was never opened anew
    connection.close()


def test_a_request_in_pieces_with_a_body_arrives_whole(service: Workers, pair: Any) -> None:
    session = sessions_of(pair[1])[0]
    body = json.dumps({"text": "a door", "at_s": 1.0}).encode()
    for target in (f"/api/sessions/{session}/nothing", "/api/sessions/0.unknown/nothing"):
        request = f"POST {target} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body
        with socket.create_connection(("127.0.0.1", service.port), PATIENCE_S) as raw:
            raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for at in range(0, len(request), 7):
                raw.sendall(request[at : at + 7])
            assert raw.recv(4096).startswith(b"HTTP/1.1 404"), target


@pytest.mark.parametrize("number", [0, 1])
def test_a_body_that_is_read_with_its_headers_arrives_whole(service: Workers, number: int) -> None:
    body = bytes(300_000)  # more than is read at once, and than headers may be
    with service.visitor_of(number) as visitor:
        (cookie,) = visitor.cookies.values()
        for key in (f"{n:032x}" for n in range(6)):  # each connection is accepted by either worker
            request = (
                f"PUT /api/logs?name=a.log&upload={key} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                f"Cookie: gridbloom_visitor={cookie}\r\nContent-Length: {len(body)}\r\n"
                f"Content-Range: bytes 0-{len(body) - 1}/{2 * len(body)}\r\n\r\n"
            )
            with socket.create_connection(("127.0.0.1", service.port), PATIENCE_S) as raw:
                raw.sendall(request.encode() + body)
                assert raw.recv(4096).startswith(b"HTTP/1.1 20")
            assert visitor.get(f"/api/logs/uploads/{key}").json()["offset"] == len(body)
            visitor.delete(f"/api/logs/uploads/{key}").raise_for_status()


def test_streams_of_both_workers_and_a_log_that_the_other_has_read(service: Workers, pair: Any) -> None:
    first, second = pair
    for visitor in pair:
        (session,) = sessions_of(visitor)
        address = f"ws://127.0.0.1:{service.port}/api/sessions/{session}/stream"
        assert asyncio.run(shows_a_frame(address))
    log = first.put("/api/logs", params={"name": "a.log"}, content=carmen(5)).raise_for_status().json()
    assert once_read(first, log["id"])["state"] == "ready"
    view = first.post("/api/sessions", json={"kind": "log", "log": log["id"]}).raise_for_status().json()["id"]
    # Who has the address of a session shares it, looks at it in 3D and makes a puzzle of it, from whichever worker.
    shared = second.post(f"/api/sessions/{view}/links", json={}).raise_for_status().json()["token"]
    assert [one["token"] for one in first.get(f"/api/sessions/{view}/links").json()["links"]] == [shared]
    assert second.get(f"/scenes/{view}").headers["location"] == f"/scenes/{view}/"
    token = first.post(f"/api/sessions/{view}/links", json={}).raise_for_status().json()["token"]
    # The other worker learns of the link from the records.
    answer = until(lambda: (got := second.get(f"/api/shared/{token}")).status_code == 200 and got)
    assert "a.log" in answer.text
    guest = second.post(f"/api/shared/{token}/sessions", json={}).raise_for_status().json()["id"]
    assert guest.startswith("1.")
    # Who has opened it is sent away wherever that was.
    first.delete(f"/api/links/{token}").raise_for_status()
    assert until(lambda: second.get(f"/api/sessions/{guest}").status_code == 404)


def test_a_class_is_followed_from_the_other_worker(service: Workers, pair: Any) -> None:
    lecturer, follower = pair
    code = lecturer.post("/api/classes").raise_for_status().json()["code"]
    assert worker_of_class(normalised(code), 2) == 0
    assert follower.get(f"/class/{code}").headers["location"].startswith(f"/class/{code}/")
    assert follower.get(f"/class/{code}/lecture.html").status_code == 200
    assert lecturer.delete(f"/api/classes/{code}").status_code == 204


async def last_code(address: str, headers: dict[str, str]) -> int | None:
    """The code with which the service closes a stream of a class."""
    async with asyncio.timeout(PATIENCE_S), stream_at(address, additional_headers=headers) as stream:
        await stream.wait_closed()
        return stream.close_code  # type: ignore[no-any-return]


async def moved_when(address: str, cookie: str, work: Callable[[], Any]) -> tuple[int | None, Any]:
    """The code with which a follower's stream is closed because of some work, and what the work returns."""
    closing = asyncio.create_task(last_code(address, {"Cookie": f"gridbloom_visitor={cookie}"}))
    async with asyncio.timeout(PATIENCE_S):
        done = await asyncio.to_thread(work)
        return await closing, done


def test_the_class_of_the_command_line_is_taken_over_from_either_worker(tmp_path: Path) -> None:
    code = next(code for code in iter(new_code, "") if worker_of_class(code, 2) == 0)
    with (
        serving(tmp_path, GRIDBLOOM_CLASS_CODE=code) as service,
        service.visitor_of(1) as lecturer,
        service.visitor_of(0) as follower,
    ):
        assert follower.get(f"/api/classes/{code}").json()["present"] == 0  # it is open before there is a lecturer
        stream = f"ws://127.0.0.1:{service.port}/api/classes/{code}/stream"

        def taken_over() -> str:
            until(lambda: follower.get(f"/api/classes/{code}").json()["present"] == 1)
            return str(lecturer.post("/api/classes").raise_for_status().json()["code"])

        # A page connects again after this close code.
        assert asyncio.run(moved_when(stream, follower.cookies["gridbloom_visitor"], taken_over)) == (1012, code)
        assert lecturer.get("/api/classes").json()["code"] == code
        assert follower.get(f"/class/{code}").headers["location"].startswith(f"/class/{code}/")
        others = follower.post("/api/classes").raise_for_status().json()["code"]
        assert others != code
        assert lecturer.delete(f"/api/classes/{others}").status_code == 404
        assert lecturer.get(f"/api/classes/{code}/results.csv").status_code == 200

        before = service.workers()
        os.kill(max(before), signal.SIGKILL)  # the lecturer's: the class waits again for somebody to take it over
        until(lambda: max(before) not in service.workers() and len(service.workers()) == 2)
        assert follower.delete(f"/api/classes/{others}").status_code == 204
        assert follower.post("/api/classes").raise_for_status().json()["code"] == code


def test_wrong_codes_of_both_workers_count_together(service: Workers) -> None:
    codes = [f"BCD{a}{b}F" for a in "GHJK" for b in "LMNP"]
    assert {worker_of_class(code, 2) for code in codes[:13]} == {0, 1}
    with service.visitor_of(0) as guessing:
        assert [guessing.get(f"/api/classes/{code}").status_code for code in codes[:13]] == 12 * [404] + [429]
    with service.visitor_of(0) as other:
        assert other.get(f"/api/classes/{codes[0]}").status_code == 404


def test_the_figures_and_the_budget_are_those_of_all_workers(service: Workers, pair: Any) -> None:
    assert counted(service, "gridbloom_sessions") == 2
    for visitor in pair * 2:
        visitor.post("/api/sessions", json=WORLD).raise_for_status()
    assert counted(service, "gridbloom_sessions") == 6
    assert counted(service, "gridbloom_remake_seconds_count") >= 0
    assert {len(sessions_of(visitor)) for visitor in pair} == {3}

    def is_full() -> bool:  # the others' use is stated now and then; the oldest own session makes room then
        before = len(sessions_of(pair[0])) + len(sessions_of(pair[1]))
        pair[1].post("/api/sessions", json=WORLD).raise_for_status()
        return before == len(sessions_of(pair[0])) + len(sessions_of(pair[1]))

    assert until(is_full)


def test_a_worker_that_is_killed_takes_only_its_sessions(service: Workers, pair: Any) -> None:
    before = [sessions_of(visitor) for visitor in pair]
    killed = min(service.workers())
    os.kill(killed, signal.SIGKILL)
    until(lambda: killed not in service.workers() and len(service.workers()) == 2)
    # Requests for it wait for the worker that replaces it.
    after = [sessions_of(visitor) for visitor in pair]
    assert sorted(map(len, after)) == [0, 1]
    assert [one for one in after if one] == [one for one, now in zip(before, after, strict=True) if now]
    for number, visitor in enumerate(pair):
        assert visitor.post("/api/sessions", json=WORLD).raise_for_status().json()["id"].startswith(f"{number}.")


def test_workers_are_replaced_at_sighup_and_end_with_their_supervisor(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        before = service.workers()
        with service.visitor_of(1) as visitor:
            log = visitor.put("/api/logs", params={"name": "a.log"}, content=carmen(5)).raise_for_status().json()["id"]
            assert once_read(visitor, log)["state"] == "ready"
            service.process.send_signal(signal.SIGHUP)
            until(lambda: len(after := service.workers()) == 2 and not after & before)
            assert once_read(visitor, log)["state"] == "ready"
        left = service.workers()
        service.process.kill()
        assert service.process.wait(PATIENCE_S) == -signal.SIGKILL
        until(lambda: not any(is_running(pid) for pid in left))
    # What is kept is where one process keeps it.
    with contextlib.closing(sqlite3.connect(tmp_path / "library" / "library.db")) as records:
        assert records.execute("SELECT name FROM logs").fetchall() == [("a.log",)]
    assert any(one.name.startswith(log) for one in (tmp_path / "library" / "packs").iterdir())


def test_an_upload_under_way_ends_before_its_worker_is_replaced(tmp_path: Path) -> None:
    with serving(tmp_path) as service, service.visitor_of(1) as visitor:
        before, data, half, key = service.workers(), carmen(3000), 100_000, "k" * 20
        cookie = "; ".join(f"{name}={value}" for name, value in visitor.cookies.items())
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", service.port, timeout=PATIENCE_S)) as sending:
            sending.putrequest("PUT", f"/api/logs?name=half.log&upload={key}")
            sending.putheader("Content-Length", str(len(data)))
            sending.putheader("Content-Range", f"bytes 0-{len(data) - 1}/{len(data)}")
            sending.putheader("Cookie", cookie)
            sending.endheaders(data[:half])

            def is_under_way() -> bool:  # then a part of it over another connection is refused for that
                part = {"Content-Range": f"bytes 5-5/{len(data)}"}
                answer = visitor.put("/api/logs", params={"name": "a", "upload": key}, content=b"x", headers=part)
                return bool(answer.json()["code"] == "upload.busy")

            until(is_under_way)
            service.process.send_signal(signal.SIGHUP)

            def is_closed() -> bool:  # to further uploads, which a page sends again
                return visitor.put("/api/logs", params={"name": "b.log"}, content=carmen(5)).status_code == 503

            until(is_closed)
            assert len(service.workers() & before) == 1
            sending.send(data[half:])
            answer = sending.getresponse()
            assert answer.status == 202
            log = json.loads(answer.read())["id"]
        until(lambda: len(after := service.workers()) == 2 and not after & before)
        assert once_read(visitor, log)["state"] == "ready"


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
