"""Log lines contain no secret: no service token, session id or link token."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
import structlog
import viser
from websockets.exceptions import InvalidHandshake
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from server.logging import configure_logging, short_hash, without_secrets
from tests.marks import also_long
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until

TOKEN = "correct-horse-battery"
BEARER = {"Authorization": f"Bearer {TOKEN}"}


@contextmanager
def logging_as(form: str) -> Iterator[None]:
    """Log as the service does, to the standard error of now."""
    root, kept = logging.getLogger(), (logging.getLogger().handlers, logging.getLogger().level)
    configure_logging(form, "info")  # debug lines would be those of the test's own HTTP client, too
    try:
        yield
    finally:
        root.handlers, level = kept
        root.setLevel(level)
        structlog.reset_defaults()


def visit(
    service: Service, path: str, protocol: str, seen: Callable[[], Any] = lambda: True, *, refused: bool = False
) -> None:
    """Open a WebSocket, read a message, and leave once all is ``seen``."""
    url = f"ws://127.0.0.1:{service.port}{path}"
    protocols = [Subprotocol(protocol)]
    if refused:
        with pytest.raises(InvalidHandshake):
            connect(url, subprotocols=protocols, proxy=None)
        return
    with connect(url, subprotocols=protocols, additional_headers=BEARER, proxy=None, max_size=None) as socket:
        socket.recv(60)
        until(seen)


@pytest.mark.parametrize("form", ["json", *also_long("console")])
def test_no_log_line_contains_a_secret(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, form: str
) -> None:
    failed = []

    def failing(*_: object) -> None:
        failed.append(1)
        raise RuntimeError(f"no picture of /api/sessions/{session_id}/map.png?token={TOKEN}")

    with logging_as(form), running(settings_for(tmp_path, token=TOKEN)) as service:
        http = service.http
        http.headers.update(BEARER)
        log = once_read(http, http.put("/api/logs", content=carmen(5)).json()["id"])
        session_id = http.post("/api/sessions", json={"kind": "log", "log": log["id"]}).json()["id"]
        world_id = service.begin()
        link = http.post(f"/api/sessions/{session_id}/links", json={})
        secret = link.json()["token"]
        base = f"http://127.0.0.1:{service.port}"
        guest_id = httpx.post(f"{base}/api/shared/{secret}/sessions", json={}, timeout=PATIENCE_S).json()["id"]
        httpx.get(f"{base}/shared/{secret}", timeout=PATIENCE_S)
        httpx.get(f"{base}/?token={TOKEN}", timeout=PATIENCE_S)
        httpx.get(f"{base}/api/sessions/{session_id}?token=wrong-{TOKEN}", timeout=PATIENCE_S)
        for one in (session_id, guest_id, world_id):
            visit(service, f"/api/sessions/{one}/stream", "gridbloom.v3")
            visit(service, f"/scenes/{one}/", f"viser-v{viser.__version__}")
        visit(service, f"/api/sessions/{session_id}/stream", "gridbloom.v3", refused=True)
        until(lambda: len(service.state.scenes) == 3)
        with monkeypatch.context() as patched:
            patched.setattr("server.scenes.scene.Scene._draw", failing)
            visit(service, f"/scenes/{world_id}/", f"viser-v{viser.__version__}", lambda: failed)
            patched.setattr("server.http.routes.maps.compressed_image", failing)
            assert http.get(f"/api/sessions/{session_id}/map.pgm").status_code == 500
        http.delete(f"/api/sessions/{world_id}")
        until(lambda: len(service.state.scenes) == 2)
    told = capsys.readouterr().err
    for event in (
        "session began", "session ended", "scene opened", "scene closed", "scene not drawn", "a request failed",
        "no picture of",
    ):  # fmt: skip
        assert event in told
    assert short_hash(world_id) in told
    for hidden in (session_id, world_id, guest_id, secret, TOKEN):
        assert [line for line in told.splitlines() if hidden in line] == []


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("GET /api/sessions/Ab_1-x/map.pgm 500", "GET /api/sessions/…/map.pgm 500"),
        ("GET /scenes/Ab_1-x/ 200", "GET /scenes/…/ 200"),
        ("POST /api/shared/Ab_1-x/sessions", "POST /api/shared/…/sessions"),
        ("GET /logs.html?session=Ab_1-x&token=a%20b", "GET /logs.html?session=…&token=…"),
        ("sessions=3 session=ab12cd34", "sessions=3 session=ab12cd34"),
    ],
)
def test_secrets_in_addresses_are_left_out(line: str, told: str) -> None:
    assert without_secrets(line) == told
