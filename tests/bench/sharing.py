"""``python -m tests.bench sharing``: latency of one visitor's slider beside three long stories, as a ratio."""

from __future__ import annotations

import contextlib
import json
import select
import statistics
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Subprotocol

from mapper.io.export.recording import write_mcap
from mapper.sensors.scan import ScanLog
from tests.browser.running import running_server

PATIENCE_S = 300.0
STORIES = 3
EDITS, STEPS = 900, 6000
LAPS, ROUNDS = 12, 3  #: laps of each kind in a round, rounds in turn: a machine has good and bad moments
BEGUN_S = 1.0  #: the stories have computed for so long when the laps begin
MINE = "192.0.2.1"
#: The stories' visitors and addresses. Behind a proxy on loopback X-Forwarded-For names a client's address.
CASES = {
    "one visitor, another address": ("same", ("198.51.100.7",) * STORIES),
    "three visitors, one other address": ("each", ("198.51.100.7",) * STORIES),
    "three visitors, three addresses": ("each", tuple(f"198.51.100.{n}" for n in range(STORIES))),
    "three visitors, the slider's address": ("each", (MINE,) * STORIES),
}


def long_story() -> dict[str, Any]:
    """Return a story of many edits, after each of which the robot plans its way again."""
    journal = [
        [i * STEPS // EDITS, {"type": "edit", "added": [["box", 300 + i, 300, 340 + i, 340]], "erased": []}]
        for i in range(EDITS)
    ]
    return {"journal": journal, "steps": STEPS}


@contextlib.contextmanager
def stories(server: str, visitors: Sequence[str], addresses: Sequence[str]) -> Iterator[None]:
    """Have stories replayed while the block runs: a visitor's cookie and an address for each."""
    body = json.dumps(
        {"kind": "simulation", "world": "office", "seed": 1, "story": long_story()}, separators=(",", ":")
    )
    place = urlsplit(server)
    with ExitStack() as stack:
        pages = []
        for visitor, address in zip(visitors, addresses, strict=True):
            page = stack.enter_context(contextlib.closing(HTTPConnection(place.hostname or "", place.port)))
            headers = {
                "Content-Type": "application/json",
                "Cookie": f"gridbloom_visitor={visitor}",
                "X-Forwarded-For": address,
            }
            page.request("POST", "/api/sessions", body, headers)
            pages.append(page.sock)
        time.sleep(BEGUN_S)
        yield
        answered, _, _ = select.select(pages, [], [], 0.0)
        if answered:
            raise RuntimeError("A story was refused, or over before the laps were.")


class Slider:
    """A visitor at the end of a log, who moves a slider and waits for the map."""

    def __init__(self, socket: Connection) -> None:
        self._socket = socket
        self._moves = 0

    def read(self) -> dict[str, Any] | None:
        """Return the next message; None for tiles, which are acknowledged."""
        data = self._socket.recv(timeout=PATIENCE_S)
        if isinstance(data, bytes):
            self._send("ack", seq=int.from_bytes(data[8:12], "little"))
            return None
        message: dict[str, Any] = json.loads(data)
        return message

    def _send(self, kind: str, **more: Any) -> None:
        self._socket.send(json.dumps({"type": kind} | more))

    def at_the_end(self, count: int) -> None:
        """Go to the end of the log."""
        self._send("pause")
        self._send("seek", index=count)
        while True:
            message = self.read()
            if message is not None and message["type"] == "frame" and message["index"] == count:
                return

    def lap(self) -> float:
        """Move the slider; return the seconds until the map with the new value is there."""
        self._moves += 1
        return self.ask({"window": 0.3 + 0.05 * (self._moves % 2)})

    def ask(self, values: dict[str, float]) -> float:
        """Change parameters; return the seconds until the map with their values is there."""
        began = time.perf_counter()
        self._send("parameters", values=values)
        while True:
            message = self.read()
            if message is not None and message["type"] == "parameters" and values.items() <= message["values"].items():
                return time.perf_counter() - began


def begin(server: str, log_id: str) -> tuple[str, int, dict[str, str]]:
    """Begin a session of a log; return its id, its scans, and the visitor's cookie."""
    with httpx.Client(base_url=server, timeout=PATIENCE_S, headers={"X-Forwarded-For": MINE}) as person:
        answer = person.post("/api/sessions", json={"kind": "log", "log": log_id, "playing": False})
        answer.raise_for_status()
        session = answer.json()
        return session["id"], session["count"], dict(person.cookies)


def sharing(log: ScanLog) -> None:
    """Print the slider's time alone and beside stories, median and 95 %, and their ratios."""
    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        logs.mkdir()
        with (logs / "hall.mcap").open("wb") as file:
            write_mcap(file, log)
        with running_server(Path(folder), "--logs-dir", str(logs)) as server:
            entries = httpx.get(f"{server}/api/logs", timeout=PATIENCE_S).json()["logs"]
            print("\n| a slider of | beside | alone | beside it | ratio |\n| --- | --- | --- | --- | --- |")
            for entry in entries:
                session_id, count, cookies = begin(server, entry["id"])
                address = f"{server.replace('http', 'ws', 1)}/api/sessions/{session_id}/stream"
                cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
                with connect(
                    address,
                    subprotocols=[Subprotocol("gridbloom.v3")],
                    additional_headers={"Cookie": cookie},
                    max_size=None,
                ) as socket:
                    slider = Slider(socket)
                    slider.at_the_end(count)
                    for case, (whose, addresses) in CASES.items():
                        _print_case(server, slider, f"{entry['name']}, {count} scans", case, whose, addresses)


def _print_case(server: str, slider: Slider, what: str, case: str, whose: str, addresses: Sequence[str]) -> None:
    visitors = [f"{'visitor' if whose == 'same' else f'visitor{n}':_<24}" for n in range(STORIES)]
    single_threaded: list[float] = []
    beside: list[float] = []
    for _ in range(ROUNDS):
        single_threaded += [slider.lap() for _ in range(LAPS)]
        with stories(server, visitors, addresses):
            beside += [slider.lap() for _ in range(LAPS)]
        time.sleep(BEGUN_S)
    medians = [statistics.median(times) for times in (single_threaded, beside)]
    tails = [statistics.quantiles(times, n=20)[-1] for times in (single_threaded, beside)]
    cells = [f"{1000 * median:.0f} / {1000 * tail:.0f} ms" for median, tail in zip(medians, tails, strict=True)]
    ratio = f"{medians[1] / medians[0]:.2f} / {tails[1] / tails[0]:.2f}"
    print(f"| {what} | {STORIES} stories of {case} | {' | '.join(cells)} | {ratio} |", flush=True)
