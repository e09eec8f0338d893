"""The HTTP interface: sessions, maps, tables, health, pages, and one shape for every error."""

from __future__ import annotations

import io
import json
import re
import threading
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image
from prometheus_client.parser import text_string_to_metric_families
from starlette.middleware.gzip import GZipResponder

from mapper.io.maps import load_map
from mapper.mapping.parameters import PARAMETERS
from mapper.simulation import WORLDS
from server.http import page_files
from tests.server.service import PATIENCE_S, Service


def test_a_session_can_begin_paused(service: Service) -> None:
    sample = service.http.get("/api/logs").json()["logs"][0]["id"]
    for wanted in ({"kind": "simulation", "world": "room"}, {"kind": "log", "log": sample}):
        for playing in (True, False):
            answer = service.http.post("/api/sessions", json=wanted | {"playing": playing})
            assert answer.status_code == 201, answer.text
            assert answer.json()["playing"] is playing


def test_a_session_from_beginning_to_end(service: Service) -> None:
    answer = service.http.post("/api/sessions", json={"kind": "simulation", "world": "room", "seed": 5})
    assert answer.status_code == 201
    session = answer.json()
    address = f"/api/sessions/{session['id']}"
    assert answer.headers["location"] == address
    assert session["stream"] == f"{address}/stream"
    assert service.http.get(address).json() == session
    assert session["id"] in [s["id"] for s in service.http.get("/api/sessions").json()["sessions"]]
    assert service.http.delete(address).status_code == 204
    assert service.http.get(address).status_code == 404


def test_the_map_can_be_downloaded(service: Service, tmp_path: Path) -> None:
    session_id = service.begin(kind="simulation", world="room", seed=5)
    for ending in ("yaml", "pgm"):
        answer = service.http.get(f"/api/sessions/{session_id}/map.{ending}")
        assert answer.headers["content-disposition"] == f'attachment; filename="room.{ending}"'
        (tmp_path / f"room.{ending}").write_bytes(answer.content)
    grid = service.state.sessions.get(session_id).model.grid
    assert grid is not None
    loaded = load_map(tmp_path / "room.yaml").grid
    assert loaded.geometry == grid.geometry
    np.testing.assert_array_equal(loaded.classify(), grid.classify())
    picture = Image.open(io.BytesIO(service.http.get(f"/api/sessions/{session_id}/map.png").content))
    assert picture.size == (grid.geometry.cols, grid.geometry.rows)


def test_the_tables(service: Service) -> None:
    worlds = service.http.get("/api/worlds").json()["worlds"]
    assert [w["name"] for w in worlds] == list(WORLDS)
    tables = service.http.get("/api/parameters").json()
    assert [row["name"] for row in tables["parameters"]] == [row.name for row in PARAMETERS]
    assert {row["group"] for row in tables["sensor"]} == {"sensor"}


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "code"),
    [
        ("GET", "/nothing/here", None, 404, "http.not_found"),
        ("GET", "/assets/../../pyproject.toml", None, 404, "http.not_found"),
        ("GET", "/assets/%2e%2e/%2e%2e/pyproject.toml", None, 404, "http.not_found"),
        ("GET", "/assets/x%00.js", None, 404, "http.not_found"),
        ("GET", "/..%2fpyproject.toml", None, 404, "http.not_found"),
        ("PATCH", "/api/worlds", None, 405, "http.method_not_allowed"),
        ("GET", "/api/sessions/unknown", None, 404, "session.unknown"),
        ("GET", "/api/sessions/unknown/map.pgm", None, 404, "session.unknown"),
        ("GET", "/scenes/unknown", None, 404, "session.unknown"),
        ("DELETE", "/api/sessions/unknown", None, 404, "session.unknown"),
        ("POST", "/api/sessions", b"{", 422, "request.invalid"),
        ("POST", "/api/sessions", b"[" * 50_000, 400, "http.bad_request"),
        ("POST", "/api/sessions", b"{}", 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"dream"}', 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"simulation","seed":-1}', 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"simulation","seed":1e400}', 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"simulation","world":"mars"}', 422, "world.name"),
        ("POST", "/api/sessions", b'{"kind":"simulation","more":1}', 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"log"}', 422, "request.invalid"),
        ("POST", "/api/sessions", b'{"kind":"log","log":"unknown"}', 404, "log.not_found"),
        ("POST", "/api/sessions", b'{"kind":"log","log":"sample-office","trajectory":"dreams"}', 422, "log.trajectory"),
        ("POST", "/api/sessions", b"\xff\xfe", 422, "request.invalid"),
    ],
)
def test_every_error_has_the_one_shape(
    service: Service, method: str, path: str, body: bytes | None, status: int, code: str
) -> None:
    answer = service.http.request(method, path, content=body, headers={"content-type": "application/json"})
    error = answer.json()
    assert (answer.status_code, error["code"]) == (status, code)
    assert set(error) == {"code", "message", "detail"}
    assert error["message"].endswith((".", "…"))
    assert "Traceback" not in answer.text
    assert str(Path(__file__).parents[3]) not in answer.text


def test_a_defect_shows_nothing_of_itself(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> None:
        raise RuntimeError("a secret of the service's")

    monkeypatch.setattr("server.sessions.SessionRegistry.all", broken)
    answer = service.http.get("/api/sessions")
    assert answer.status_code == 500
    assert answer.json()["code"] == "internal"
    assert "secret" not in answer.text
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_a_visitor_with_too_many_sessions_is_refused(service: Service) -> None:
    state = service.state.sessions
    original = service.state.settings
    state._settings = original.model_copy(update={"max_sessions_per_visitor": 1})
    try:
        with httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S) as visitor:
            first = visitor.post("/api/sessions", json={"kind": "simulation"}).json()["id"]
            client = state.get(first).hub.join()
            answer = visitor.post("/api/sessions", json={"kind": "simulation"})
            assert (answer.status_code, answer.json()["code"]) == (429, "session.too_many")
            assert "retry-after" in answer.headers
            state.get(first).hub.leave(client)
    finally:
        state._settings = original


def test_health(service: Service) -> None:
    assert service.http.get("/livez").json() == {"status": "alive"}
    assert service.http.get("/readyz").json() == {"status": "ready"}


def test_metrics_count(service: Service) -> None:
    def figures() -> dict[str, float]:
        text = service.http.get("/metrics").text
        return {
            sample.name + json.dumps(sample.labels, sort_keys=True): sample.value
            for family in text_string_to_metric_families(text)
            for sample in family.samples
        }

    before = figures()
    session_id = service.begin()
    after = figures()
    assert after['gridbloom_sessions{"kind": "simulation"}'] == before['gridbloom_sessions{"kind": "simulation"}'] + 1
    assert after["gridbloom_cells{}"] == before["gridbloom_cells{}"] + service.state.sessions.get(session_id).cells
    assert {"gridbloom_clients{}", "gridbloom_frames_total{}", "gridbloom_stream_bytes_total{}"} <= set(after)
    assert {"gridbloom_dirty_tiles{}", "gridbloom_remake_seconds_count{}"} <= set(after)


def test_the_interface_is_described_without_any_other_host(service: Service) -> None:
    document = service.http.get("/api/openapi.json").json()
    assert "/api/sessions" in document["paths"]
    page = service.http.get("/api/docs").text
    for path in document["paths"]:
        assert path in page
    assert not re.findall(r"(?:src|href)=\"(?:https?:)?//", page)
    assert "<script" not in page


@pytest.fixture
def built_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of pages as Vite would build them."""
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html><title>front</title>")
    (tmp_path / "lab.html").write_text("<!doctype html><title>lab</title>" + " " * 4000)
    (tmp_path / "assets" / "lab-1a2b.js").write_text("export const x = 1;" * 500)
    (tmp_path / ".digest").write_text("secret")
    (tmp_path / "assets" / "link.js").symlink_to(Path(__file__))
    monkeypatch.setattr(page_files, "PLACES", (tmp_path,))
    return tmp_path


def test_a_long_answer_is_compressed_beside_the_event_loop(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page of 40 kB takes a millisecond, as long as many a request."""
    threads: list[str] = []

    class Noting(GZipResponder):
        def _compress_body(self, body: bytes, more_body: bool) -> bytes:
            threads.append(threading.current_thread().name)
            return super()._compress_body(body, more_body)

    monkeypatch.setattr("starlette.middleware.gzip.GZipResponder", Noting)
    assert service.http.get("/api/docs").headers["content-encoding"] == "gzip"
    assert [name == "uvicorn" for name in threads] == [False]
    assert any(thread.name == "uvicorn" for thread in threading.enumerate()), "the event loop's"


@pytest.mark.usefixtures("built_pages")
def test_pages_and_assets(service: Service) -> None:
    assert "<title>front" in service.http.get("/").text
    lab = service.http.get("/lab.html?session=x")
    assert "<title>lab" in lab.text
    assert lab.headers["cache-control"] == "no-cache"
    assert lab.headers["content-encoding"] == "gzip"
    assert service.http.get("/lab.html", headers={"if-none-match": lab.headers["etag"]}).status_code == 304
    asset = service.http.get("/assets/lab-1a2b.js")
    assert asset.headers["content-type"] == "text/javascript; charset=utf-8"
    assert "immutable" in asset.headers["cache-control"]
    assert service.http.head("/lab.html").status_code == 200
    for hidden in ("/.digest", "/assets/link.js", "/assets/", "/assets", "/index.html/"):
        assert service.http.get(hidden).status_code in (404, 307), hidden


def test_a_name_without_html_redirects_to_the_page(service: Service, built_pages: Path) -> None:
    answer = service.http.get("/lab?world=office&seed=3", follow_redirects=False)
    assert answer.status_code == 307
    assert answer.headers["location"] == "/lab.html?world=office&seed=3"
    for name in ("lab.html.html", "x" * 4000, "..%2flab", "%00"):
        assert service.http.get(f"/{name}", follow_redirects=False).status_code == 404, name


def test_a_browser_is_shown_a_page_where_there_is_none(service: Service, built_pages: Path) -> None:
    (built_pages / "missing.html").write_text("<!doctype html><title>missing</title>")
    browser = {"accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    for address in ("/nothing", "/nothing/here", "/assets/gone"):
        answer = service.http.get(address, headers=browser)
        assert answer.status_code == 404, address
        assert "<title>missing" in answer.text, address
        assert service.http.get(address).json()["code"] == "http.not_found", address
    assert service.http.get("/api/sessions/unknown", headers=browser).json()["code"] == "session.unknown"


def test_without_built_pages_the_front_page_gives_advice(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_files, "PLACES", ())
    answer = service.http.get("/")
    assert answer.status_code == 503
    assert "make setup" in answer.text
    assert service.http.get("/lab.html").status_code == 404


def test_the_address_of_a_3d_view_ends_in_a_slash(service: Service) -> None:
    session_id = service.begin()
    answer = service.http.get(f"/scenes/{session_id}")
    assert answer.status_code == 308
    assert answer.headers["location"] == f"/scenes/{session_id}/"
