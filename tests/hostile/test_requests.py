"""Requests that no browser sends: each is refused in the common form, and discloses nothing of the service."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from urllib.parse import quote

import pytest

from tests.hostile.damage import ALL
from tests.server.service import PATIENCE_S, Service

ROOT = Path(__file__).parents[2]
ODD_NAMES = (
    "x",
    "\0",
    "..",
    "../..",
    "é",
    "\U0001f600",
    "%",
    "a" * 3000,
    "a" * 300 + ".html",
    "<script>",
    "-1",
    "1e999",
)
ODD_BODIES = (
    b"",
    b"null",
    b"[]",
    b"1",
    b'"x"',
    b"{}",
    b'{"kind":[]}',
    b'{"kind":"simulation","seed":' + b"9" * 4000 + b"}",
    b'{"kind":"simulation","world":{}}',
    b'{"kind":"log","log":"\\ud800"}',
    b"\0",
    b"\xff",
    b"{" * 9000,
)


def raw(service: Service, head: str, body: bytes = b"") -> tuple[int, bytes]:
    """Send a request as it stands; return the answer's status and body, once the service has closed."""
    with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as connection:
        connection.sendall(head.replace("\n", "\r\n").encode("latin-1") + b"\r\n\r\n" + body)
        parts = []
        while part := connection.recv(65536):
            parts.append(part)
    answer, _, content = b"".join(parts).partition(b"\r\n\r\n")
    return int(answer.split()[1]), content


def check_error(content: bytes) -> str:
    """Check an error's shape, and that it shows nothing; return its code."""
    error = json.loads(content)
    assert set(error) == {"code", "message", "detail"}
    assert error["message"]
    shown = content.decode()
    assert not [secret for secret in ("Traceback", str(ROOT), 'File "', "site-packages") if secret in shown]
    assert len(error["message"]) < 300
    return str(error["code"])


ASKED = {
    "an IPv6 address that is none": ("GET / HTTP/1.1\nHost: [::::]", 421, "security.host"),
    "an IPv4 address in brackets": ("GET / HTTP/1.1\nHost: [1.2]", 421, "security.host"),
    "no host": ("GET / HTTP/1.0", 421, "security.host"),
    "half a bracket": ("POST /api/sessions HTTP/1.1\nHost: {host}\nOrigin: http://[", 403, "security.origin"),
    "an origin in brackets": ("POST /api/sessions HTTP/1.1\nHost: {host}\nOrigin: http://[x]", 403, "security.origin"),
    "two origins": (
        "POST /api/sessions HTTP/1.1\nHost: {host}\nOrigin: http://{host}\nOrigin: http://{host}",
        403, "security.origin",
    ),
    "a method of its own": ("BREW / HTTP/1.1\nHost: {host}", 405, "http.method_not_allowed"),
    "a proxy's address": ("GET http://evil.example/livez HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a tunnel": ("CONNECT evil.example:80 HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a page of a long name": ("GET /" + "a" * 5000 + ".html HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "an asset far down": ("GET /assets/" + "a/" * 3000 + "a.js HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a file above the assets": ("GET /assets/../../../../etc/passwd HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a file above the scenes": ("GET /scenes/x/../../etc/passwd HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a header in a session": ("GET /scenes/%0d%0aSet-Cookie:a=b HTTP/1.1\nHost: {host}", 404, "session.unknown"),
    "a stream without an upgrade": ("GET /api/sessions/x/stream HTTP/1.1\nHost: {host}", 404, "http.not_found"),
    "a terabyte": ("POST /api/sessions HTTP/1.1\nHost: {host}\nContent-Length: 999999999999", 413, "request.too_large"),
    "a terabyte of log": ("PUT /api/logs HTTP/1.1\nHost: {host}\nContent-Length: 999999999999", 413, "log.too_large"),
    "a cookie of backslashes": (
        'GET /api/sessions/x HTTP/1.1\nHost: {host}\nCookie: a="' + "\\" * 50_000, 404, "session.unknown"
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", ASKED)
def test_an_odd_request_is_refused_in_the_common_shape(service: Service, case: str) -> None:
    head, status, code = ASKED[case]
    host = f"127.0.0.1:{service.port}"
    answer, content = raw(service, head.replace("{host}", host) + "\nConnection: close")
    assert (answer, check_error(content)) == (status, code)


@pytest.mark.parametrize(
    "head",
    [
        "POST /api/sessions HTTP/1.1\nHost: {host}\nContent-Length: -1",
        "POST /api/sessions HTTP/1.1\nHost: {host}\nContent-Length: " + "9" * 5000,
        "POST /api/sessions HTTP/1.1\nHost: {host}\nContent-Length: 1\nContent-Length: 2",
        "PUT /api/logs HTTP/1.1\nHost: {host}\nTransfer-Encoding: chunked\n\nzz",
        "GET /livez HTTP/1.1\nHost: {host}\nHost: evil.example",
        "GET /livez HTTP/1.1\nHost: {host}\nX: " + "a" * 200_000,
        "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        "GET /x HTTP/1.1\nHost: {host}\nConnection: Upgrade\nUpgrade: websocket\nSec-WebSocket-Version: 13",
    ],
)
def test_data_that_is_no_request_is_refused(service: Service, head: str) -> None:
    try:
        status, content = raw(service, head.replace("{host}", f"127.0.0.1:{service.port}"))
    except ConnectionError:  # closed before all of it was read
        return
    assert status == 400
    assert b"Traceback" not in content


@pytest.mark.sampled
@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"])
def test_every_route_handles_odd_names_and_bodies(service: Service, method: str) -> None:
    """Every address that the interface describes, and those of the pages, with what nobody sends.

    Every fourth name in turn, so that each address meets three and each name a quarter of all addresses. Where an
    address has not the method, which the router refuses whatever is sent, every twelfth.
    """
    described = service.http.get("/api/openapi.json").json()["paths"]
    pages = dict.fromkeys(("/", "/assets/{a}", "/{a}", "/scenes/{a}/"), ("get", "head"))
    codes = set()
    for place, (path, methods) in enumerate({**described, **pages}.items()):
        for number, odd in enumerate(ODD_NAMES):
            if not ALL and (place + number) % (4 if method.lower() in methods else 12):
                continue
            parts = [quote(odd, safe="") if part.startswith("{") else part for part in path.split("/")]
            body = ODD_BODIES[number % len(ODD_BODIES)] if method not in ("GET", "HEAD", "OPTIONS") else None
            answer = service.http.request(
                method,
                "/".join(parts),
                params={"name": odd, "session": odd, "token": odd},
                content=body,
                headers={"content-type": ("application/json", "text/plain", "multipart/form-data")[number % 3]},
            )
            where = (method, path, odd[:20], body)
            assert answer.status_code < 500 or (path, answer.status_code) == ("/", 503), where  # pages are not built
            if 400 <= answer.status_code < 500 and method != "HEAD":
                codes.add(check_error(answer.content))
    assert codes <= {
        "http.not_found", "http.method_not_allowed", "http.bad_request", "request.invalid", "session.unknown",
        "log.not_found", "log.empty", "world.name", "link.gone", "parameter.unknown", "parameters.text",
        "parameters.yaml", "amcl.yaml", "amcl.unknown", "class.unknown", "class.guesses", "puzzle.gone",
        "puzzle.no_game", "puzzle.unknown",
    }  # fmt: skip


@pytest.mark.parametrize("body", ODD_BODIES)
def test_every_odd_body_of_a_new_session_is_refused(service: Service, body: bytes) -> None:
    answer = service.http.post("/api/sessions", content=body, headers={"content-type": "application/json"})
    assert answer.status_code in (400, 404, 422)
    assert check_error(answer.content) in ("request.invalid", "http.bad_request", "log.not_found")


def test_a_name_that_no_file_can_have_is_not_there(
    service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "index.html").write_text("<!doctype html>")
    (tmp_path / "round.html").symlink_to("round.html")
    monkeypatch.setattr("server.http.page_files.PLACES", (tmp_path,))
    assert service.http.get("/index.html").status_code == 200
    for name in ("a" * 5000 + ".html", "assets/" + "a/" * 3000 + "a.js", "round.html"):
        answer = service.http.get("/" + name)
        assert (answer.status_code, check_error(answer.content)) == (404, "http.not_found")


def test_a_request_without_its_body_is_cancelled(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.http.security.BODY_S", 0.2)
    head = f"POST /api/sessions HTTP/1.1\nHost: 127.0.0.1:{service.port}\nContent-Length: 100"
    status, content = raw(service, head, b'{"kind":')
    assert (status, check_error(content)) == (408, "request.stalled")


def test_an_invalid_handshake_ends_its_connection(service: Service) -> None:
    """The service would wait for the rest of it for ever, and stumble over it when it ends."""
    with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as connection:
        connection.sendall(
            f"POST /api/sessions/x/stream HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n".encode()
            + b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            + b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        assert connection.recv(1000) == b""
