"""The computer's clock is set an hour ahead, then back: who is signed in stays so, and nothing waits or is lost."""

from __future__ import annotations

import signal
from pathlib import Path

import httpx

from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, once_read
from tests.server.test_serving import RUN, started

TOKEN = "a-long-enough-token"
#: The clock of the process before anything of the service is imported: SIGUSR1 sets it ahead, SIGUSR2 back.
PROGRAM = f"""
import signal, time
read, shift_s = time.time, 0.0

def set_clock(number, _):
    global shift_s
    shift_s += 3600.0 if number == signal.SIGUSR1 else -7200.0
    print("set", flush=True)

time.time = lambda: read() + shift_s
signal.signal(signal.SIGUSR1, set_clock)
signal.signal(signal.SIGUSR2, set_clock)
{RUN}
"""


def test_a_clock_that_is_set_ahead_and_back(tmp_path: Path) -> None:
    process, address = started(PROGRAM, tmp_path, GRIDBLOOM_TOKEN=TOKEN)
    assert process.stdout is not None
    base = address.partition("/?")[0]
    try:
        with httpx.Client(base_url=base, timeout=PATIENCE_S) as client:
            assert client.get("/api/worlds", params={"token": TOKEN}).status_code in (200, 303, 307)
            began = client.post("/api/sessions", json={"kind": "simulation", "world": "room"}).json()["id"]
            room = client.post("/api/classes", json={"session": began})
            assert room.status_code == 201, room.text
            logs = {}
            for step, number in enumerate((None, signal.SIGUSR1, signal.SIGUSR2)):
                if number is not None:
                    process.send_signal(number)
                    assert process.stdout.readline() == "set\n"
                answer = client.put("/api/logs", params={"name": f"log {step}"}, content=carmen(5 + step))
                assert answer.status_code == 202, answer.text
                logs[f"log {step}"] = answer.json()["id"]
                assert once_read(client, answer.json()["id"])["state"] == "ready"
                assert client.get(f"/api/sessions/{began}").status_code == 200
                assert client.get(f"/api/classes/{room.json()['code']}").status_code == 200
                mine = {one["name"]: one["id"] for one in client.get("/api/logs").json()["logs"]}
                assert logs.items() <= mine.items()
                other = client.post("/api/sessions", json={"kind": "log", "log": logs["log 0"]})
                assert other.status_code == 201, other.text
                assert client.delete(f"/api/sessions/{other.json()['id']}").status_code == 204
            with httpx.Client(base_url=base, timeout=PATIENCE_S) as stranger:
                assert stranger.get("/api/logs").status_code == 401
                assert stranger.get("/api/logs", params={"token": TOKEN}, follow_redirects=True).status_code == 200
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
    assert process.returncode == 0
    assert "Traceback" not in errors
