"""Host, Origin, token, visitor, headers, sizes: which requests are accepted."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from pydantic import ValidationError
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from server.settings import Settings
from tests.server.service import PATIENCE_S, Service, running, settings_for, stream_at, until, until_closed

TOKEN = "correct-horse-battery"


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service that asks for a token and has a name."""
    folder = tmp_path_factory.mktemp("guarded")
    with running(settings_for(folder, token=TOKEN, allowed_hosts="maps.example.org")) as service:
        yield service


@pytest.fixture
def browser(guarded: Service) -> Iterator[httpx.Client]:
    """A browser that was never here."""
    with httpx.Client(base_url=f"http://127.0.0.1:{guarded.port}", timeout=PATIENCE_S) as client:
        yield client


def is_error(answer: httpx.Response, status: int, code: str) -> bool:
    body = answer.json()
    return answer.status_code == status and set(body) == {"code", "message", "detail"} and body["code"] == code


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "", "a b", "[::1", "8.8.8.8"]
)
def test_a_name_that_is_not_ours_is_refused(service: Service, host: str) -> None:
    assert is_error(service.http.get("/api/worlds", headers={"host": host}), 421, "security.host")


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:1234", "localhost:9000", "[::1]:8000", "LOCALHOST"])
def test_our_own_names_are_answered(service: Service, host: str) -> None:
    assert service.http.get("/api/worlds", headers={"host": host}).status_code == 200


def test_a_name_that_was_allowed_is_answered(browser: httpx.Client) -> None:
    headers = {"host": "maps.example.org", "authorization": f"Bearer {TOKEN}"}
    assert browser.get("/api/worlds", headers=headers).status_code == 200
    assert browser.get("/api/worlds", headers=headers | {"host": "maps.example.com"}).status_code == 421


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "null", "http://127.0.0.1:1", "file://", "http://127.0.0.1.evil.example"]
)
async def test_other_sites_pages_can_neither_change_nor_watch(service: Service, origin: str) -> None:
    session_id = service.begin()
    for method, path in (("POST", "/api/sessions"), ("DELETE", f"/api/sessions/{session_id}"), ("PUT", "/api/logs")):
        answer = service.http.request(method, path, headers={"origin": origin})
        assert is_error(answer, 403, "security.origin")
    with pytest.raises(InvalidStatus) as refused:
        await connect(service.address(session_id), origin=origin, subprotocols=["gridbloom.v3"])  # type: ignore[arg-type,list-item]
    assert refused.value.response.status_code == 403
    assert service.http.get(f"/api/sessions/{session_id}").status_code == 200


async def test_our_own_pages_can(service: Service) -> None:
    origin = f"http://127.0.0.1:{service.port}"
    answer = service.http.post(
        "/api/sessions", json={"kind": "simulation", "world": "room"}, headers={"origin": origin}
    )
    assert answer.status_code == 201
    async with service.connect(answer.json()["id"], origin=origin) as socket:
        assert json.loads(await socket.recv())["type"] == "hello"


@pytest.mark.parametrize(
    "path", ["/", "/api/worlds", "/api/logs", "/metrics", "/api/openapi.json", "/assets/../api/logs"]
)
def test_without_the_token_requests_are_refused(browser: httpx.Client, path: str) -> None:
    assert is_error(browser.get(path), 401, "security.token")
    assert is_error(browser.get(path, headers={"authorization": "Bearer wrong"}), 401, "security.token")
    assert is_error(browser.get(path, headers={"authorization": "Basic " + TOKEN}), 401, "security.token")
    assert is_error(browser.get(path + "?token=correct-horse"), 401, "security.token")
    assert is_error(browser.get(path, headers={"cookie": f"gridbloom_token={TOKEN}"}), 401, "security.token")
    page = browser.get(path, headers={"accept": "text/html"})
    assert page.status_code == 401
    assert 'name="token"' in page.text


def test_without_the_token_a_proxy_learns_only_whether_the_service_is_ready(browser: httpx.Client) -> None:
    answer = browser.get("/readyz")
    assert (answer.status_code, answer.json()) == (200, {"status": "ready"})


def test_without_the_token_there_is_the_program_of_the_page_that_a_link_opens(browser: httpx.Client) -> None:
    assert is_error(browser.get("/assets/x.js"), 404, "http.not_found")
    assert is_error(browser.get("/api/shared/no-such-link"), 404, "link.gone")


def test_livez_is_open(browser: httpx.Client) -> None:
    assert browser.get("/livez").json() == {"status": "alive"}


def test_the_token_in_the_address_becomes_a_cookie(browser: httpx.Client) -> None:
    first = browser.get(f"/api/worlds?a=1&token={TOKEN}&b=%26")
    assert first.status_code == 303
    assert first.headers["location"] == "/api/worlds?a=1&b=%26"
    assert TOKEN not in first.headers["set-cookie"]
    assert "gridbloom_signed_in=1" in first.headers["set-cookie"], "for the pages, which link to the way out"
    assert "HttpOnly" in first.headers["set-cookie"]
    assert browser.get("/api/worlds").status_code == 200


def test_a_browser_that_signs_out_must_give_the_token_again(guarded: Service, browser: httpx.Client) -> None:
    other = httpx.Client(base_url=browser.base_url, timeout=PATIENCE_S)
    for one in (browser, other):
        one.get("/", params={"token": TOKEN})
        assert one.get("/api/worlds").status_code == 200
    assert "Sign out" in browser.get("/sign-out").text
    kept = browser.cookies["gridbloom_token"]
    assert browser.post("/sign-out").status_code == 303
    assert "gridbloom_token" not in browser.cookies
    assert is_error(browser.get("/api/worlds", headers={"cookie": f"gridbloom_token={kept}"}), 401, "security.token")
    assert other.get("/api/worlds").status_code == 200
    browser.get("/", params={"token": TOKEN})
    assert browser.post("/sign-out", data={"everywhere": "1"}).status_code == 303
    assert other.get("/api/worlds").status_code == 401
    other.get("/", params={"token": TOKEN})
    assert other.get("/api/worlds").status_code == 200
    other.close()


@pytest.mark.parametrize("everywhere", [False, True])
async def test_the_sockets_of_a_browser_that_signs_out_close(guarded: Service, *, everywhere: bool) -> None:
    clients = [httpx.Client(base_url=guarded.http.base_url, timeout=PATIENCE_S) for _ in range(2)]
    leaving, staying = clients
    for one in clients:
        one.get("/", params={"token": TOKEN})
    session = leaving.post("/api/sessions", json={"kind": "simulation", "world": "room"}).json()["id"]
    code = leaving.post("/api/classes").json()["code"]
    of_class = f"ws://127.0.0.1:{guarded.port}/api/classes/{code}/stream"

    def cookies(client: httpx.Client) -> dict[str, str]:
        return {"Cookie": "; ".join(f"{name}={value}" for name, value in client.cookies.items())}

    ended, going_on = cookies(leaving), cookies(staying)
    async with (
        guarded.connect(session, additional_headers=ended) as own,
        stream_at(of_class, additional_headers=ended) as lecturing,
        guarded.connect(session, additional_headers=going_on) as another,
        stream_at(of_class, additional_headers=going_on) as following,
    ):
        data = {"everywhere": "1"} if everywhere else {}
        assert (await asyncio.to_thread(leaving.post, "/sign-out", data=data)).status_code == 303
        for socket in (own, lecturing, *((another, following) if everywhere else ())):
            await until_closed(socket)
            assert socket.close_code == 4401
        if not everywhere:
            await another.send('{"type":"ping","id":7}')
            while json.loads(message if isinstance(message := await another.recv(), str) else "{}").get("id") != 7:
                pass
            assert following.state.name == "OPEN"
        async with stream_at(
            of_class, additional_headers=ended
        ) as again:  # the visitor's cookie alone does not lecture
            await until_closed(again)
            assert again.close_code == 4404
    for one in clients:
        one.close()


def test_the_way_from_the_token_leads_nowhere_else(browser: httpx.Client) -> None:
    answer = browser.get(f"//evil.example/?token={TOKEN}")
    assert answer.headers.get("location", "/").startswith("/")
    assert not answer.headers.get("location", "/").startswith("//")


def test_programs_send_it_in_a_header(browser: httpx.Client) -> None:
    assert browser.get("/api/worlds", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200


async def test_a_socket_needs_the_token_too(guarded: Service) -> None:
    guarded.http.headers["authorization"] = f"Bearer {TOKEN}"
    session_id = guarded.begin()
    with pytest.raises(InvalidStatus):
        await connect(guarded.address(session_id), subprotocols=["gridbloom.v3"])  # type: ignore[list-item]
    async with guarded.connect(session_id, additional_headers={"authorization": f"Bearer {TOKEN}"}) as socket:
        assert json.loads(await socket.recv())["type"] == "hello"


def test_each_browser_is_a_visitor_of_its_own(service: Service) -> None:
    with httpx.Client(base_url=f"http://127.0.0.1:{service.port}") as one, httpx.Client(base_url=one.base_url) as two:
        cookie = one.get("/livez").headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Lax" in cookie
        assert "set-cookie" not in one.get("/livez").headers
        session_id = one.post("/api/sessions", json={"kind": "simulation", "world": "room"}).json()["id"]
        assert [s["id"] for s in one.get("/api/sessions").json()["sessions"]] == [session_id]
        assert two.get("/api/sessions").json() == {"sessions": []}
        assert two.get(f"/api/sessions/{session_id}").status_code == 200  # a link shares it
        assert is_error(two.delete(f"/api/sessions/{session_id}"), 403, "session.not_yours")
        assert one.delete(f"/api/sessions/{session_id}").status_code == 204
        assert is_error(one.get(f"/api/sessions/{session_id}"), 404, "session.unknown")


@pytest.mark.parametrize(
    "cookie", ["gridbloom_visitor=../../x", "gridbloom_visitor=", "a=b; ;;=", "gridbloom_visitor=" + "x" * 5000]
)
def test_an_invalid_cookie_makes_a_new_visitor(service: Service, cookie: str) -> None:
    answer = httpx.get(f"http://127.0.0.1:{service.port}/livez", headers={"cookie": cookie})
    assert answer.status_code == 200
    assert "gridbloom_visitor=" in answer.headers["set-cookie"]


@pytest.mark.parametrize("path", ["/", "/api/worlds", "/livez", "/nothing/here", "/api/docs"])
def test_every_answer_has_its_headers(service: Service, path: str) -> None:
    headers = service.http.get(path).headers
    assert "default-src 'self'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "same-origin"


def test_bodies_are_bounded(service: Service) -> None:
    def endless() -> Iterator[bytes]:
        while True:
            yield b" " * 4096

    too_much: list[Any] = [b"x" * 70_000, endless()]
    for content in too_much:
        try:
            answer = service.http.post("/api/sessions", content=content, headers={"content-type": "application/json"})
        except httpx.WriteError:
            continue  # the server closed the connection on a body without end
        assert is_error(answer, 413, "request.too_large")
    assert service.http.get("/livez").status_code == 200


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("localhost", True),
        ("::1", True),
        ("127.8.8.8", True),
        ("0.0.0.0", False),
        ("::", False),
        ("x", False),
    ],
)
def test_off_loopback_there_is_always_a_token(host: str, loopback: bool) -> None:
    settings = Settings(host=host).with_token()
    assert settings.is_loopback is loopback
    assert (settings.token is None) is loopback
    if settings.token is not None:
        assert len(settings.token.get_secret_value()) >= 32
        assert Settings(host=host).with_token().token != settings.token
        assert settings.token.get_secret_value() not in repr(settings)


@pytest.mark.parametrize(
    ("names", "asks"),
    [
        ("", False),
        ("localhost, 127.0.0.2, [::1], maps.localhost", False),
        ("maps.example.org", True),
        ("localhost, maps.example.org", True),
        ("192.168.0.7", True),
        ("localhost.example.org", True),
        ("*", True),
    ],
)
def test_a_host_name_beyond_loopback_requires_a_token(names: str, asks: bool) -> None:
    options: dict[str, Any] = {"allowed_hosts": names}
    settings = Settings(**options)
    assert (settings.with_token().token is not None) is asks
    assert Settings(**options, no_token=True).with_token().token is None


def test_a_service_behind_a_reverse_proxy_requires_its_generated_token(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, allowed_hosts="maps.example.org")) as service:
        for host in ("maps.example.org", "127.0.0.1"):
            assert is_error(service.http.get("/api/worlds", headers={"host": host}), 401, "security.token")
    with running(settings_for(tmp_path, allowed_hosts="maps.example.org", no_token=True)) as service:
        assert service.http.get("/api/worlds", headers={"host": "maps.example.org"}).status_code == 200


def test_a_token_and_none_contradict_each_other() -> None:
    options: dict[str, Any] = {"token": TOKEN, "no_token": True}
    with pytest.raises(ValidationError, match="contradict"):
        Settings(**options)


def test_guesses_of_the_token_are_braked_and_cookies_are_not(tmp_path: Path) -> None:
    with running(settings_for(tmp_path, token=TOKEN)) as service:
        http = service.http
        http.get("/", params={"token": TOKEN})
        with httpx.Client(base_url=http.base_url, timeout=PATIENCE_S) as guessing:
            wrong = {"authorization": "Bearer wrong-token"}
            answers = [guessing.get("/api/worlds", headers=wrong).status_code for _ in range(50)]
            assert answers == [401] * 50

            def right_after_wrong() -> httpx.Response | None:
                """Return the refusal of the right token; None on a machine so slow that guesses are allowed again."""
                while guessing.get("/api/worlds", headers=wrong).status_code != 429:
                    pass
                answer = guessing.get("/api/worlds", headers={"authorization": f"Bearer {TOKEN}"})
                return answer if answer.status_code == 429 else None

            right = until(right_after_wrong)
            assert is_error(right, 429, "security.guesses")
            assert int(right.headers["retry-after"]) >= 1
            assert guessing.get("/livez").status_code == 200
        assert http.get("/api/worlds").status_code == 200
