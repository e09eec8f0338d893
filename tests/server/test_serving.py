"""Start-up: settings from the environment, the printed address, a port in use, deferred imports."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path

import httpx
import pytest
import structlog
from pydantic import ValidationError

from server.logging import configure_logging
from server.serving import address_of, listen
from server.settings import Settings
from tests.marks import also_long
from tests.server.service import PATIENCE_S

ROOT = Path(__file__).parents[2]
RUN = "from server.serving import run; from server.settings import Settings; run(Settings())"


@pytest.mark.parametrize(("cores", "workers"), [(1, 1), (2, 1), (3, 3), (4, 4)])
def test_auto_is_a_worker_for_each_of_more_than_two_cores(
    monkeypatch: pytest.MonkeyPatch, cores: int, workers: int
) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setenv("GRIDBLOOM_WORKERS", "auto")
    assert Settings().workers == workers
    monkeypatch.setenv("GRIDBLOOM_WORKERS", "2")
    assert Settings().workers == 2


def environment(folder: Path, **settings: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith("GRIDBLOOM_")}
    own = {f"GRIDBLOOM_{name.upper()}": value for name, value in settings.items()}
    return kept | {"GRIDBLOOM_DATA_DIR": str(folder), "PYTHONPATH": str(ROOT)} | own


@pytest.mark.parametrize("wish", [signal.SIGTERM, *also_long(signal.SIGINT)])
def test_it_prints_its_address_and_ends_on_a_signal(tmp_path: Path, wish: signal.Signals) -> None:
    process = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", RUN],
        env=environment(tmp_path, port="0", token="a-long-enough-token", log_format="json"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.fullmatch(r"Gridbloom runs at (http://127\.0\.0\.1:(\d+)/\?token=a-long-enough-token)\n", line)
    assert found, line
    address = found[1].replace("/?", "/api/worlds?")
    with urllib.request.build_opener(urllib.request.HTTPCookieProcessor()).open(address, timeout=PATIENCE_S) as answer:
        assert b"office" in answer.read()
    process.send_signal(wish)
    out, errors = process.communicate(timeout=PATIENCE_S)
    assert out == ""
    assert process.returncode == 0
    assert "a-long-enough-token" not in errors
    assert "Traceback" not in errors
    assert "Warning" not in errors


@pytest.mark.parametrize("no_token", [False, *also_long(True)])
def test_behind_a_reverse_proxy_it_prints_its_token_or_a_warning(tmp_path: Path, no_token: bool) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", "from server.cli import main; main()", "serve", *["--no-token"] * no_token],
        env=environment(tmp_path, port="0", allowed_hosts="maps.example.org"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
    assert ("?token=" in line) is not no_token
    assert ("no token is required" in errors) is no_token


def test_a_port_in_use_gives_one_sentence(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        done = subprocess.run(
            [sys.executable, "-c", RUN],
            env=environment(tmp_path, port=port),
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    assert done.returncode == 1
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    assert f"cannot listen on 127.0.0.1 port {port}" in done.stderr


def test_importing_and_creating_the_application_does_nothing(tmp_path: Path) -> None:
    program = f"""
import os, threading
before = set(os.listdir({str(tmp_path)!r}))
import server.app, server.serving
app = server.app.create_app()
assert set(os.listdir({str(tmp_path)!r})) == before, os.listdir({str(tmp_path)!r})
assert threading.active_count() == 1, threading.enumerate()
import logging
assert not logging.getLogger().handlers
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        env=environment(tmp_path / "data"),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("host", "token", "expected"),
    [
        ("127.0.0.1", None, "http://127.0.0.1:80/"),
        ("0.0.0.0", "t", "http://127.0.0.1:80/?token=t"),
        ("::", "t", "http://[::1]:80/?token=t"),
        ("::1", None, "http://[::1]:80/"),
        ("maps.local", "t", "http://maps.local:80/?token=t"),
    ],
)
def test_the_address_can_be_opened(host: str, token: str | None, expected: str) -> None:
    assert address_of(host, 80, token) == expected


def test_port_0_selects_a_free_port() -> None:
    with listen("127.0.0.1", 0) as one, listen("127.0.0.1", 0) as other:
        assert one.getsockname()[1] != other.getsockname()[1]


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRIDBLOOM_PORT", "9000")
    monkeypatch.setenv("GRIDBLOOM_ALLOWED_HOSTS", "a.example, b.example")
    settings = Settings()
    assert settings.port == 9000
    assert settings.allowed_hosts == ("a.example", "b.example")
    assert Settings(port=1).port == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("PORT", "70000"),
        ("PORT", "x"),
        ("TOKEN", "short"),
        ("MAX_SESSIONS", "0"),
        ("SESSION_IDLE_S", "nan"),
        ("LOG_FORMAT", "xml"),
    ],
)
def test_a_setting_that_makes_no_sense_is_refused(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    monkeypatch.setenv(f"GRIDBLOOM_{name}", value)
    with pytest.raises(ValidationError):
        Settings()


def test_every_setting_has_a_description() -> None:
    for name, field in Settings.model_fields.items():
        assert field.description, name
        assert field.description.endswith((".", ")")) or "or" in field.description, name


@pytest.mark.parametrize("form", ["console", "json"])
def test_log_lines(form: str, capsys: pytest.CaptureFixture[str]) -> None:
    root, kept = logging.getLogger(), (logging.getLogger().handlers, logging.getLogger().level)
    try:
        configure_logging(form, "info")
        structlog.get_logger("one").info("session began", cells=5)
        structlog.get_logger("one").debug("not this")
        logging.getLogger("library").warning("from elsewhere")
        secret = "the " + "token"
        try:
            raise ZeroDivisionError(secret[:3])
        except ZeroDivisionError:
            structlog.get_logger("one").exception("failed")
    finally:
        root.handlers, _ = kept
        root.setLevel(kept[1])
        structlog.reset_defaults()
    lines = capsys.readouterr().err
    assert "session began" in lines
    assert "from elsewhere" in lines
    assert "ZeroDivisionError" in lines
    assert "not this" not in lines
    assert "the token" not in lines


def started(program: str, folder: Path, **more: str) -> tuple[subprocess.Popen[str], str]:
    """A service in a process of its own, and its address."""
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment(folder, port="0") | more,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    found = re.search(r"http://\S+", process.stdout.readline())
    assert found
    return process, found[0]


#: Imported with the first session, download, log or export, or never: the service answers sooner without them.
NOT_AT_THE_START = (
    "PIL", "alembic", "dask", "mapper.io.logs.opening", "mapper.mapping.integrate", "mapper.matching.match",
    "mapper.replay", "mapper.simulation.worlds", "mapper.slam.slam", "mcap", "numba", "pydantic.v1", "rich", "scipy",
    "server.scenes.proxy", "server.sessions.host",
    "server.sources.log", "server.sources.simulation", "server.stream.hub", "viser", "yaml",
)  # fmt: skip


def test_it_is_ready_without_kernels_and_without_the_modules_that_few_requests_need(tmp_path: Path) -> None:
    cache = tmp_path / "kernels"
    program = f"""
import atexit, sys
atexit.register(lambda: print([name for name in {NOT_AT_THE_START} if name in sys.modules]))
sys.argv = ["gridbloom", "serve"]
from server.cli import main
main()
"""
    process, address = started(program, tmp_path / "data", NUMBA_CACHE_DIR=str(cache))
    try:
        assert httpx.get(f"{address}readyz", timeout=PATIENCE_S).json() == {"status": "ready"}
        process.send_signal(signal.SIGTERM)
        out, _ = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
    assert process.returncode == 0
    assert out == "[]\n"
    assert [path for path in cache.rglob("*") if path.suffix in (".nbi", ".nbc")] == []


def test_it_ends_while_a_session_computes_that_cannot_be_interrupted(tmp_path: Path) -> None:
    """As a kernel that compiles: a thread that never ends holds neither the service nor its process."""
    program = f"""
import time
import server.sources.simulation_replay

def never_ends(*_, **__):
    print("computing", flush=True)
    time.sleep(10_000)

server.sources.simulation_replay.replayed = never_ends
{RUN}
"""
    process, address = started(program, tmp_path)
    try:
        visitor = threading.Thread(target=post_and_be_cut, args=(f"{address}api/sessions",))
        visitor.start()
        assert process.stdout is not None
        assert process.stdout.readline() == "computing\n"
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE_S)
        visitor.join()
    finally:
        process.kill()
    assert process.returncode == 0
    assert "Traceback" not in errors


def post_and_be_cut(address: str) -> None:
    with contextlib.suppress(httpx.TransportError):
        httpx.post(address, json={"kind": "simulation", "world": "room"}, timeout=PATIENCE_S)
