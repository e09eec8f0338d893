"""All kernels are compiled beside a running service, at the lowest priority, and those of the lab loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import TypeAdapter
from starlette.routing import Match

from server.app import create_app
from server.serving import make_server
from server.settings import Settings
from server.warm_up import COMMAND, WarmUp
from tests.server.service import PATIENCE_S, running, settings_for, until

# The first session of a service that has loaded what sessions need, and three frames of it.
PROGRAM = """
import gc
import os
import sys
from pathlib import Path

from fastapi.testclient import TestClient

from server.app import create_app
from server.logging import configure_logging
from server.settings import Settings
from server.warm_up import load_sessions

load_sessions()
configure_logging("console", "error")
settings = Settings(data_dir=Path(sys.argv[1]))
with TestClient(create_app(settings), base_url="http://localhost") as http:
    before = set(sys.modules)
    session = http.post("/api/sessions", json={"kind": "simulation", "world": "office"}).raise_for_status().json()["id"]
    with http.websocket_connect(f"ws://localhost/api/sessions/{session}/stream", ["gridbloom.v3"]) as stream:
        seq = 0
        while seq < 3:
            if frame := stream.receive().get("bytes"):
                seq = int.from_bytes(frame[8:12], "little")
                stream.send_json({"type": "ack", "seq": seq})
        print(gc.get_freeze_count() / len(gc.get_objects()))  # the second are without the first
        print(*sorted(name for name in set(sys.modules) - before if name.startswith(("mapper.", "numba."))), flush=True)
        os._exit(0)  # the test client ends streams with an error now and then
"""


@pytest.fixture
def compiling(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[WarmUp]:
    """A process that has begun to compile all kernels into a new folder."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    warm_up = WarmUp()
    warm_up.begin()
    try:
        assert os.getpriority(os.PRIO_PROCESS, process_of(warm_up).pid) == 19  # from the first
        until(lambda: any(tmp_path.glob("*-kernels-*/*/*.nbi")))
        yield warm_up
    finally:
        warm_up.end()


def process_of(warm_up: WarmUp) -> subprocess.Popen[bytes]:
    assert warm_up.process is not None
    return warm_up.process


def said_by_another() -> bytes:
    """Run the command while its standard input stays open; return what it prints: something if it compiled."""
    with subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        said = process.stdout.read()
        assert process.wait() == 0
    return said


def test_a_process_of_the_lowest_priority_compiles_until_it_is_ended(compiling: WarmUp) -> None:
    process = process_of(compiling)
    assert os.getpriority(os.PRIO_PROCESS, process.pid) == 19
    compiling.end()
    assert process.poll() not in (None, 0)


@pytest.mark.long
def test_it_ends_with_the_process_that_began_it(compiling: WarmUp) -> None:
    """The system closes the other end of its standard input then."""
    process = process_of(compiling)
    assert process.stdin is not None
    process.stdin.close()
    until(lambda: process.poll() is not None)


@pytest.mark.long
def test_one_process_compiles_at_a_time(compiling: WarmUp) -> None:
    assert said_by_another() == b""
    assert process_of(compiling).poll() is None


def test_nothing_is_compiled_where_all_kernels_are() -> None:
    """As they are after `make kernels`, with which `make test` begins."""
    said_by_another()
    assert said_by_another() == b""


def test_a_service_begins_and_ends_it_where_the_setting_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    happened: list[str] = []
    monkeypatch.setattr(WarmUp, "begin", lambda _: happened.append("begin"))
    monkeypatch.setattr(WarmUp, "end", lambda _: happened.append("end"))
    assert make_server(settings_for(tmp_path / "without")).warm_up is None
    with running(settings_for(tmp_path / "with", compile_ahead=True)) as service:
        assert service.http.get("/readyz").status_code == 200
        assert happened == ["begin"]
    assert happened == ["begin", "end"]


def test_the_first_session_loads_nothing_and_a_full_collection_looks_through_little(tmp_path: Path) -> None:
    compiled = [sys.executable, "-m", "mapper.tools.precompile", "--lab"]
    subprocess.run(compiled, check=True, capture_output=True, timeout=PATIENCE_S)
    program = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    done = subprocess.run(program, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    ratio, _, loaded = done.stdout.partition("\n")
    assert loaded.split() == []
    assert float(ratio) > 5.0


def test_no_request_waits_for_the_models_of_routes(monkeypatch: pytest.MonkeyPatch) -> None:
    app = create_app(Settings())

    def made(*_: object, **__: object) -> None:
        raise AssertionError("FastAPI makes the models of a route")

    monkeypatch.setattr(TypeAdapter, "__init__", made)
    scope = {"type": "http", "method": "GET", "path": "/none/of/them", "root_path": "", "headers": []}
    assert not any(route.matches(dict(scope))[0] is Match.FULL for route in app.routes)
