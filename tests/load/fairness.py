"""The slider of one visitor, alone and beside the heaviest requests of another one at another address."""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import statistics
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import httpx
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from tests.bench.sharing import PATIENCE_S, STORIES, Slider, begin, stories
from tests.load.served import service

LOG = "sample-office"
ADDRESS = "198.51.100.7"  #: of the other visitor
VISITOR = "other".ljust(24, "_")
HEADERS = {"X-Forwarded-For": ADDRESS, "Cookie": f"gridbloom_visitor={VISITOR}"}
LAPS, ROUNDS = 10, 3  #: laps of each kind in a round, rounds in turn: a machine has good and bad moments
BEGUN_S = 1.0  #: the other visitor's requests run for so long when the laps begin
AT_ONCE = 4  #: threads of the other visitor, each with a request at a time
TRICKLES, PIECE, PIECES_PER_S = 8, 30, 10.0  #: uploads of 300 bytes a second

Request = Callable[[str, int, threading.Event], None]


@contextmanager
def _client(server: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=server, timeout=PATIENCE_S, headers=HEADERS) as http:
        yield http


@contextmanager
def _session(server: str) -> Iterator[tuple[httpx.Client, str]]:
    with _client(server) as http:
        answer = http.post("/api/sessions", json={"kind": "log", "log": LOG, "playing": False})
        answer.raise_for_status()
        session_id = str(answer.json()["id"])
        try:
            yield http, session_id
        finally:
            http.delete(f"/api/sessions/{session_id}")


def _fine_maps(server: str, _: int, over: threading.Event) -> None:
    """Have the whole log mapped with cells of 2 cm, again and again."""
    with _session(server) as (_http, session_id):
        address = f"{server.replace('http', 'ws', 1)}/api/sessions/{session_id}/stream"
        with connect(address, subprotocols=[Subprotocol("gridbloom.v3")], max_size=None) as stream:
            slider = Slider(stream)
            slider.at_the_end(600)
            for resolution in itertools.cycle((0.02, 0.021)):
                if over.is_set():
                    return
                slider.ask({"resolution": resolution})


def _pictures(server: str, _: int, over: threading.Event) -> None:
    with _session(server) as (http, session_id):
        while not over.is_set():
            http.get(f"/api/sessions/{session_id}/map.png")


def _downloads(server: str, _: int, over: threading.Event) -> None:
    with _session(server) as (http, session_id):
        while not over.is_set():
            http.get(f"/api/sessions/{session_id}/run.mcap")


def _doctors(server: str, _: int, over: threading.Event) -> None:
    while not over.is_set():  # of a session the result is kept
        with _session(server) as (http, session_id):
            http.get(f"/api/sessions/{session_id}/doctor")


def _trickle(server: str, _: int, over: threading.Event) -> None:
    place = httpx.URL(server)
    with ExitStack() as stack:
        halves = []
        for n in range(TRICKLES // AT_ONCE):
            one = stack.enter_context(socket.create_connection((place.host, place.port or 0)))
            head = f"PUT /api/logs?name=slow{n} HTTP/1.1\r\nHost: {place.host}:{place.port}\r\n"
            head += "".join(f"{name}: {value}\r\n" for name, value in HEADERS.items())
            one.sendall(f"{head}Content-Length: 10000000\r\n\r\n".encode())
            halves.append(one)
        while not over.wait(1.0 / PIECES_PER_S):
            for one in halves:
                with contextlib.suppress(OSError):  # refused: it is too slow
                    one.sendall(b"#" * PIECE)


@contextmanager
def _repeated(server: str, request: Request) -> Iterator[None]:
    """Have requests made by :data:`AT_ONCE` threads while the block runs."""
    over = threading.Event()
    made: list[BaseException] = []

    def run(n: int) -> None:
        try:
            request(server, n, over)
        except (httpx.HTTPError, ConnectionClosed) as error:
            made.append(error)

    threads = [threading.Thread(target=run, args=(n,)) for n in range(AT_ONCE)]
    for one in threads:
        one.start()
    time.sleep(BEGUN_S)
    try:
        yield
    finally:
        over.set()
        for one in threads:
            one.join()
    if made:
        raise RuntimeError(f"requests of the other visitor ended: {made[0]!r}")


CASES: dict[str, Request] = {
    "maps of 2 cm": _fine_maps,
    "pictures": _pictures,
    "downloads of MCAP": _downloads,
    "doctor runs": _doctors,
    "trickling uploads": _trickle,
}


def _beside(server: str, case: str) -> contextlib.AbstractContextManager[None]:
    if case in CASES:
        return _repeated(server, CASES[case])
    return stories(server, [VISITOR] * STORIES, [ADDRESS] * STORIES)


def fairness() -> None:
    """Print the slider's time alone and beside each kind of request, and their ratio."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; median and 95 % of {LAPS * ROUNDS} moves, ms")
    print(f"{'':<24}" + "".join(f"{name:>10}" for name in ("alone", "95 %", "beside", "95 %", "ratio")))
    with service(64, 64) as process:
        server = f"http://127.0.0.1:{process.port}"
        session_id, count, cookies = begin(server, LOG)
        cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
        address = f"{server.replace('http', 'ws', 1)}/api/sessions/{session_id}/stream"
        headers, protocols = {"Cookie": cookie}, [Subprotocol("gridbloom.v3")]
        for case in ("long stories", *CASES):
            alone: list[float] = []
            beside: list[float] = []
            for _ in range(ROUNDS):
                with connect(address, subprotocols=protocols, additional_headers=headers, max_size=None) as stream:
                    slider = Slider(stream)
                    slider.at_the_end(count)
                    alone += [slider.lap() for _ in range(LAPS)]
                    with _beside(server, case):
                        beside += [slider.lap() for _ in range(LAPS)]
                time.sleep(BEGUN_S)
            cells = [1000.0 * of(times) for times in (alone, beside) for of in (statistics.median, _most)]
            ratio = cells[2] / cells[0]
            print(f"{case:<24}" + "".join(f"{value:>10.0f}" for value in cells) + f"{ratio:>10.2f}", flush=True)


def _most(times: list[float]) -> float:
    return statistics.quantiles(times, n=20)[-1]
