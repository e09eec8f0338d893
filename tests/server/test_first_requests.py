"""The first requests of a kind import what they need beside the event loop, and nobody reads the program's text.

The first state of a session, all of its messages and its map, is made beside it as well.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROGRAM = """
import asyncio, inspect, sys
from pathlib import Path

import viser
from websockets.sync.client import connect
from websockets.typing import Subprotocol
from server.sessions import SessionHost
from tests.server.service import once_read, running, settings_for, until
from tests.server.library.small_logs import carmen

seen = []

def on_loop():
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name.startswith(("server.", "mapper.", "scipy", "numba", "PIL")) and on_loop():
            seen.append(name)

def noted(of):
    if on_loop():
        seen.append(f"source of {of}")
    return lines(of)

lines, inspect.getsourcelines = inspect.getsourcelines, noted

def prepared(host, model):
    if on_loop():
        seen.append("first state of a session")
    prepare(host, model)

prepare, SessionHost.prepare = SessionHost.prepare, prepared

with running(settings_for(Path(sys.argv[1]))) as service:
    http = service.http
    sys.meta_path.insert(0, Watch())
    log = http.put("/api/logs", params={"name": "small"}, content=carmen(50)).raise_for_status().json()["id"]
    once_read(http, log)
    once_read(http, "sample-office")
    http.get("/api/logs").raise_for_status()
    puzzles = http.get("/api/puzzles").raise_for_status().json()["puzzles"]
    key = puzzles[0]["name"]
    http.get(f"/api/puzzles/{key}/map.png").raise_for_status()
    code = http.post("/api/classes", json={}).raise_for_status().json()["code"]

    def read(path, protocol="gridbloom.v3"):
        cookies = "; ".join(f"{name}={value}" for name, value in http.cookies.items())
        with connect(
            f"ws://127.0.0.1:{service.port}{path}",
            subprotocols=[Subprotocol(protocol)],
            additional_headers={"Cookie": cookies},
        ) as socket:
            socket.recv()

    read(f"/api/classes/{code}/stream")
    session = service.begin()
    read(f"/api/sessions/{session}/stream")
    assert http.get(f"/scenes/{session}/").status_code in (200, 503)  # without built pages there is none
    read(f"/scenes/{session}", f"viser-v{viser.__version__}")
    opened = service.begin(kind="log", log=log)
    http.get(f"/api/sessions/{opened}/map.png").raise_for_status()
    until(lambda: http.get(f"/api/sessions/{opened}/contents").status_code == 200)
    http.get(f"/api/sessions/{opened}/contents/fields").raise_for_status()
    http.get(f"/api/sessions/{opened}/doctor").raise_for_status()
    http.get(f"/api/sessions/{opened}/report").raise_for_status()
print(*seen)
"""


def test_no_first_request_blocks_the_event_loop(tmp_path: Path) -> None:
    program = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    done = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == ""
