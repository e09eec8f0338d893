"""Read-only links to a view of a log, on an open service and on one with a token."""

from __future__ import annotations

import asyncio
import io
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from websockets.exceptions import InvalidStatus

from mapper.grid import GridGeometry
from mapper.io.costmaps import RecordedCostmap, write_costmaps
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.server.library.small_logs import carmen
from tests.server.service import (
    PATIENCE_S,
    Service,
    Watcher,
    once_read,
    running,
    settings_for,
    stream_at,
    until,
    until_closed,
)

TOKEN = "the-token-of-this-service"
ODDS = 1.75


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("links")


@pytest.fixture(scope="module")
def service(folder: Path) -> Iterator[Service]:
    with running(settings_for(folder, token=TOKEN, max_sessions=6, max_sessions_per_visitor=2)) as service:
        yield service


@pytest.fixture
def browser(service: Service) -> Iterator[Callable[..., httpx.Client]]:
    """Makes browsers, that of somebody who knows the service's token or of a guest who does not."""
    made: list[httpx.Client] = []

    def new(*, guest: bool = False) -> httpx.Client:
        headers = {} if guest else {"Authorization": f"Bearer {TOKEN}"}
        made.append(httpx.Client(base_url=f"http://127.0.0.1:{service.port}", headers=headers, timeout=PATIENCE_S))
        made[-1].get("/api/logs")  # the first answer brings the cookie
        return made[-1]

    yield new
    for client in made:
        client.close()
    for session in service.state.sessions.all():
        httpx.delete(
            f"http://127.0.0.1:{service.port}/api/sessions/{session.id}",
            headers={"Authorization": f"Bearer {TOKEN}", "Cookie": f"gridbloom_visitor={session.owner}"},
        )


@pytest.fixture
def ann(browser: Callable[..., httpx.Client]) -> httpx.Client:
    return browser()


def uploaded(client: httpx.Client, n: int = 40) -> str:
    return sent(client, "run.log", carmen(n))


def sent(client: httpx.Client, name: str, content: bytes) -> str:
    log_id = str(client.put("/api/logs", params={"name": name}, content=content).json()["id"])
    assert once_read(client, log_id)["state"] == "ready"
    return log_id


def opened(client: httpx.Client, log_id: str) -> str:
    answer = client.post("/api/sessions", json={"kind": "log", "log": log_id})
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def linked(client: httpx.Client, session: str, **more: Any) -> dict[str, Any]:
    answer = client.post(f"/api/sessions/{session}/links", json=more)
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def refusal(answer: httpx.Response) -> tuple[int, str]:
    assert set(answer.json()) == {"code", "message", "detail"}
    assert answer.json()["message"].endswith((".", "…"))
    return answer.status_code, answer.json()["code"]


async def ask(client: httpx.Client, method: str, path: str) -> httpx.Response:
    return await asyncio.to_thread(client.request, method.upper(), path)


def stream(service: Service, session: str, client: httpx.Client) -> Any:
    headers = {name: value for name, value in client.headers.items() if name == "authorization"}
    return stream_at(service.address(session), additional_headers=headers)


def test_a_link_keeps_what_its_page_shows_and_what_was_found_out_about_the_log(
    browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    session = opened(ann, uploaded(ann))
    shown = {
        "group": "notes",
        "note": None,
        "layout": "beside:map,messages:60:50",
        "message": "/imu",
        "picture": None,
        "plots": {
            "fields": [{"topic": "/imu", "field": "a.x", "made": "average", "window": 5.0}],
            "across": None,
            "zoom": [1.5, 3.0],
            "below": True,
        },
        "lines": {"least": 30, "node": "", "text": "slip"},
        "place": [1.0, -2.0],
        "measured": {"tool": "area", "points": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0, 0.5]], "size": 0.1},
        "scene": {
            "clouds": True,
            "camera": {"position": [1.0, 2.0, 3.0], "look_at": [0.0, 0.0, 0.5]},
            "layers": {"Grid": False},
            "height": 2.0,
            "chosen": "first person",
            "look": {"colour": "time", "point_size": 2.5, "cut_handles": True},
        },
        "utc": True,
        "comparison": None,
    }
    guest = browser(guest=True)
    before = guest.get(f"/api{linked(ann, session, shown=shown)['address']}").json()
    assert (before["shown"], before["examination"]) == (shown, None)
    examination = ann.get(f"/api/sessions/{session}/doctor").json()
    after = guest.get(f"/api{linked(ann, session)['address']}").json()
    assert (after["shown"], after["examination"]) == (None, examination)
    assert examination["findings"], "an empty examination would be equal to any other"
    refused: tuple[dict[str, Any], ...] = (
        {"message": "x" * 401},
        {"place": [1.0]},
        {"measured": {"tool": "area", "points": [[1.0]]}},
        {"scene": {"clouds": False, "height": 100.0}},
        {"scene": {"clouds": False, "chosen": "below"}},
        {"scene": {"clouds": True, "look": {"colour": ["time"]}}},
        {"plots": {"fields": []}},
        {"other": 1},
    )
    for wrong in refused:
        assert ann.post(f"/api/sessions/{session}/links", json={"shown": wrong}).status_code == 422


async def test_a_guest_sees_this_very_view_and_nothing_else(
    service: Service, browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    log_id = await asyncio.to_thread(uploaded, ann)
    session = opened(ann, log_id)
    async with stream(service, session, ann) as socket:
        watcher = Watcher(socket)
        await watcher.send("pause")
        await watcher.send("parameters", values={"log_odds_hit": ODDS, "update": "per_scan"})
        await watcher.send("seek", index=25)
        await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 25)
        await watcher.settle()
        theirs = watcher.log_odds()
        await watcher.send("costmap", values={"inflation_radius": 0.8, "obstacle_layer": False})
        await watcher.send("goal", x=1.0, y=0.5)
        await watcher.until(lambda: watcher.newest.get("path", {}).get("goal") == [1.0, 0.5])
    look = {"x": 1.5, "y": -2.25, "scale": 0.125, "width": 800.0, "height": 600.0}
    link = linked(ann, session, look=look)
    assert (link["address"], link["index"], link["count"]) == (f"/shared/{link['token']}", 25, 40)
    assert link["changed"] == ["log_odds_hit", "update"]
    assert len(link["token"]) == 32

    guest = browser(guest=True)
    assert guest.get(link["address"]).status_code in (200, 404), "404 where the pages are not built"
    assert guest.get(f"/api{link['address']}").json() == {
        "title": "run.log",
        "look": look,
        "shown": None,
        "examination": None,
    }
    own = guest.post(f"/api{link['address']}/sessions").json()["id"]
    async with stream(service, own, guest) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 25)
        await watcher.settle()
        frame = watcher.newest["frame"]
        assert (frame["index"], frame["playing"]) == (25, False)
        assert watcher.newest["hello"]["parameters"]["values"]["log_odds_hit"] == ODDS
        assert watcher.log_odds().tobytes() == theirs.tobytes()
        await watcher.until(lambda: watcher.newest["costmap"]["is_on"] and watcher.newest["path"]["goal"])
        assert watcher.newest["costmap"]["values"]["inflation_radius"] == 0.8
        assert watcher.newest["path"]["goal"] == [1.0, 0.5]
        # They may scrub, retune and ask why.
        await watcher.send("seek", index=3)
        await watcher.until(lambda: watcher.newest["frame"]["index"] == 3)
        await watcher.send("parameters", values={"log_odds_hit": 1.0})
        await watcher.until(lambda: watcher.newest["parameters"]["values"]["log_odds_hit"] == 1.0)
        await watcher.send("why", row=2, col=2, epoch=watcher.epoch)
        await watcher.answer("why")
        assert (await asyncio.to_thread(guest.get, f"/api/sessions/{own}/map.pgm")).status_code == 200
        # They may compare their view with another one of the same log.
        compare = f"/api/sessions/{own}/compare"
        answer = await asyncio.to_thread(guest.put, compare, json={"values": {"log_odds_hit": ODDS}})
        assert answer.json()["max_difference"] > 0.0
        answer = await asyncio.to_thread(guest.put, compare, json={"log": log_id})
        assert refusal(answer) == (403, "link.read_only")
        assert (await asyncio.to_thread(guest.get, f"{compare}.png")).status_code == 200
        assert (await asyncio.to_thread(guest.delete, compare)).status_code == 204
    # The owner's session is as it was.
    assert service.state.sessions.get(session).model.progress == (25, 40)
    asked: list[tuple[str, str]] = [
        ("GET", "/api/logs"),
        ("GET", f"/api/logs/{log_id}"),
        ("DELETE", f"/api/logs/{log_id}"),
        ("POST", f"/api/logs/{log_id}/read"),
        ("PUT", "/api/logs?name=mine"),
        ("GET", "/api/sessions"),
        ("POST", "/api/sessions"),
        ("GET", f"/api/sessions/{session}"),
        ("DELETE", f"/api/sessions/{session}"),
        ("GET", f"/api/sessions/{own}/run.mcap"),
        ("POST", f"/api/sessions/{own}/compare"),
        ("PUT", f"/api/sessions/{session}/compare"),
        ("POST", f"/api/sessions/{own}/links"),
        ("GET", f"/api/links?log={log_id}"),
        ("DELETE", f"/api/links/{link['token']}"),
        ("GET", f"/scenes/{own}/"),
        ("GET", "/logs.html"),
        ("GET", "/api/no/such/route"),
        ("POST", "/livez"),
    ]
    for method, path in asked:
        answer = await asyncio.to_thread(guest.request, method, path)
        assert refusal(answer) == (401, "security.token"), (method, path)
    with pytest.raises(InvalidStatus):
        async with stream(service, session, guest):
            pass


def test_a_guest_sees_the_map_and_the_clouds_of_the_log_in_3d(
    service: Service, browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    clouds = recorded.mcap_bytes(recording_of_room(n=4))
    session = opened(ann, sent(ann, "room.mcap", clouds))
    link, guest = linked(ann, session), browser(guest=True)
    begun = [
        guest.post(f"/api{link['address']}/sessions", params={"clouds": clouds}).json() for clouds in (False, True)
    ]
    assert [one["kind"] for one in begun] == ["log", "volume"]
    for own in begun:
        address = f"/scenes/{own['id']}"
        assert guest.get(f"{address}/plain/{'0a' * 16}/").status_code in (200, 503), "503 where the pages are not built"
        assert guest.post(f"{address}/settings", json={"height": 2.0}).json()["height"] == 2.0
    assert refusal(guest.get(f"/scenes/{session}/settings")) == (401, "security.token")
    assert [service.state.sessions.get(one["id"]).link for one in begun] == [link["token"]] * 2
    assert ann.delete(f"/api/links/{link['token']}").status_code == 204
    for own in begun:
        assert refusal(guest.get(f"/scenes/{own['id']}/settings")) == (401, "security.token")


def test_a_guest_with_the_services_token_gets_no_more_of_the_log(
    browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    log_id = uploaded(ann)
    link = linked(ann, opened(ann, log_id))
    bob = browser()
    own = bob.post(f"/api{link['address']}/sessions").json()["id"]
    for name in ("run.mcap", "trajectory.tum"):
        assert refusal(bob.get(f"/api/sessions/{own}/{name}")) == (403, "link.read_only")
    assert refusal(bob.get(f"/api/logs/{log_id}")) == (404, "log.not_found")
    assert refusal(bob.delete(f"/api/logs/{log_id}")) == (404, "log.not_found")
    assert refusal(bob.post(f"/api/sessions/{own}/links", json={})) == (403, "link.read_only")
    assert refusal(bob.delete(f"/api/links/{link['token']}")) == (404, "link.gone")
    assert bob.get(f"/api/links?log={log_id}").json() == {"links": []}


async def test_a_revoked_link_opens_nothing_and_its_sessions_end(
    service: Service, browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    log_id = await asyncio.to_thread(uploaded, ann)
    session = opened(ann, log_id)
    links = [linked(ann, session) for _ in range(2)]
    listed = (await ask(ann, "get", f"/api/links?log={log_id}")).json()["links"]
    assert [one["token"] for one in listed] == [one["token"] for one in links[::-1]]
    assert listed[0]["created_s"] == pytest.approx(time.time(), abs=60)
    guest = browser(guest=True)
    own = (await ask(guest, "post", f"/api{links[0]['address']}/sessions")).json()["id"]
    other = (await ask(guest, "post", f"/api{links[1]['address']}/sessions")).json()["id"]
    async with stream(service, own, guest) as socket:
        await socket.recv()
        assert (await ask(ann, "get", f"/api/links?log={log_id}")).json()["links"][1]["watching"] == 1
        assert (await ask(ann, "delete", f"/api/links/{links[0]['token']}")).status_code == 204
        await until_closed(socket)
        assert socket.close_code == 4410
    assert (await ask(guest, "get", f"/api/sessions/{other}")).status_code == 200
    for token in (links[0]["token"], "x" * 32):
        assert refusal(await ask(guest, "get", f"/api/shared/{token}")) == (404, "link.gone")
        assert refusal(await ask(guest, "post", f"/api/shared/{token}/sessions")) == (404, "link.gone")
        assert (await ask(guest, "get", f"/shared/{token}")).status_code == 404
    # With its log goes the other one.
    assert (await ask(ann, "delete", f"/api/logs/{log_id}")).status_code == 204
    assert refusal(await ask(guest, "get", f"/api{links[1]['address']}")) == (404, "link.gone")
    assert (await ask(guest, "get", f"/api/sessions/{other}")).status_code == 401
    assert (await ask(ann, "get", f"/api/sessions/{session}")).status_code == 200


async def test_a_guest_sees_this_costmap_of_a_recording_until_the_link_is_revoked(
    service: Service, browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    geometry = GridGeometry(0.1, 30, 40, (1.0, 2.0, 0.0))
    values = [np.full((30, 40), 20 * k, np.uint8) for k in range(9)]
    file = io.BytesIO()
    write_costmaps(file, [RecordedCostmap(k * 10**9, k * 10**9, "odom", "", geometry, v) for k, v in enumerate(values)])
    log_id = await asyncio.to_thread(sent, ann, "costs.mcap", file.getvalue())
    session = await asyncio.to_thread(opened, ann, log_id)
    async with stream(service, session, ann) as socket:
        watcher = Watcher(socket)
        await watcher.send("pause")
        await watcher.send("seek", index=6)
        await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 6)
    look = {"x": 1.5, "y": 2.25, "scale": 0.125, "width": 800.0, "height": 600.0}
    link = await asyncio.to_thread(linked, ann, session, look=look)
    assert (link["trajectory"], link["index"], link["count"]) == ("/costmap_raw", 6, 9)
    assert link["changed"] == []

    guest = browser(guest=True)
    assert (await ask(guest, "get", f"/api{link['address']}")).json() == {
        "title": "costs.mcap",
        "look": look,
        "shown": None,
        "examination": None,
    }
    begun = (await ask(guest, "post", f"/api{link['address']}/sessions")).json()
    assert (begun["kind"], begun["index"], begun["count"], begun["playing"]) == ("costmaps", 6, 9, False)
    own = begun["id"]
    costs = await ask(guest, "get", f"/api/sessions/{own}/costmap/costmap.pgm")
    assert costs.content[-values[5].size :] == values[5].tobytes()
    async with stream(service, own, guest) as socket:
        watcher = Watcher(socket)
        await watcher.send("seek", index=3)
        await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 3)
        assert service.state.sessions.get(session).model.progress == (6, 9)
        for method, path in (
            ("GET", "/api/logs"),
            ("GET", f"/api/logs/{log_id}"),
            ("DELETE", f"/api/logs/{log_id}"),
            ("GET", f"/api/sessions/{session}"),
            ("GET", f"/api/sessions/{session}/costmap/costmap.pgm"),
            ("GET", f"/api/sessions/{own}/links"),
            ("DELETE", f"/api/links/{link['token']}"),
        ):
            assert refusal(await ask(guest, method, path)) == (401, "security.token"), (method, path)
        with pytest.raises(InvalidStatus):
            async with stream(service, session, guest):
                pass
        # A guest's session makes no further links, not even for who knows the token of the service.
        again = await asyncio.to_thread(ann.post, f"/api/sessions/{own}/links", json={})
        assert refusal(again) == (403, "link.read_only")
        listed = (await ask(ann, "get", f"/api/sessions/{session}/links")).json()["links"]
        assert [(one["token"], one["watching"]) for one in listed] == [(link["token"], 1)]
        assert (await ask(ann, "delete", f"/api/sessions/{session}/links/{link['token']}")).status_code == 204
        await until_closed(socket)
        assert socket.close_code == 4410
    for method, path in (("GET", ""), ("POST", "/sessions")):
        assert refusal(await ask(guest, method, f"/api{link['address']}{path}")) == (404, "link.gone")
    assert (await ask(guest, "get", f"/api/sessions/{own}/costmap/costmap.pgm")).status_code == 401


def test_guests_do_not_evict_sessions_of_visitors(
    service: Service, browser: Callable[..., httpx.Client], ann: httpx.Client
) -> None:
    log_id = uploaded(ann)
    session = opened(ann, log_id)
    first, second = linked(ann, session), linked(ann, session)
    guests = [browser(guest=True) for _ in range(4)]
    begun = [guest.post(f"/api{first['address']}/sessions") for guest in guests[:3]]
    assert [answer.status_code for answer in begun] == [201] * 3
    # Two places for each link, half of the six for all guests; who left is the first to go, and never the owner.
    assert guests[0].get(f"/api/sessions/{begun[0].json()['id']}").status_code == 401
    for _ in range(4):
        assert guests[3].post(f"/api{second['address']}/sessions").status_code == 201
    sessions = service.state.sessions.all()
    assert sum(one.link is not None for one in sessions) == 3
    assert ann.get(f"/api/sessions/{session}").status_code == 200
    # Others need not wait for a guest to leave.
    others = [browser() for _ in range(5)]
    assert [opened(other, "sample-office") for other in others]
    assert ann.get(f"/api/sessions/{session}").status_code == 200
    assert not [one for one in service.state.sessions.all() if one.link is not None]


def test_odd_requests(ann: httpx.Client) -> None:
    world = ann.post("/api/sessions", json={"kind": "simulation", "world": "room"}).json()["id"]
    assert refusal(ann.post(f"/api/sessions/{world}/links", json={})) == (409, "session.not_a_log")
    assert refusal(ann.post("/api/sessions/none/links", json={})) == (404, "session.unknown")
    session = opened(ann, "sample-office")
    good = {"x": 0, "y": 0, "scale": 1, "width": 1, "height": 1}
    for look in ({"x": 1}, good | {"x": "nan"}, good | {"scale": 0}, good | {"height": -1}, good | {"z": 1}):
        answer = ann.post(f"/api/sessions/{session}/links", json={"look": look})
        assert refusal(answer) == (422, "request.invalid")
    for path in ("..%2flogs", "x" * 5000, "%00"):
        assert ann.get(f"/api/shared/{path}").status_code == 404


def test_the_page_of_a_secret_that_is_gone_says_so_by_its_status(
    browser: Callable[..., httpx.Client], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("index", "logs", "puzzles"):
        (tmp_path / f"{name}.html").write_text(name)
    monkeypatch.setattr("server.http.page_files.PLACES", (tmp_path,))
    guest = browser(guest=True)
    for place, name in (("/shared/none", "logs"), ("/puzzle/none", "puzzles")):
        answer = guest.get(place)
        assert (answer.status_code, answer.text, answer.headers["x-robots-tag"]) == (404, name, "noindex")


def test_links_outlive_a_restart_and_are_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.annotations.links.MAX_LINKS_PER_OWNER", 2)
    with running(settings_for(tmp_path)) as first:
        log_id = uploaded(first.http)
        link = linked(first.http, opened(first.http, log_id))
        sample = linked(first.http, opened(first.http, "sample-office"))
        refused = first.http.post(f"/api/sessions/{opened(first.http, log_id)}/links", json={})
        assert refusal(refused) == (409, "link.too_many")
    with running(settings_for(tmp_path)) as second:
        for one, title in ((link, "run.log"), (sample, "A simulated office (sample)")):
            assert second.http.get(f"/api{one['address']}").json()["title"] == title
        assert second.http.post(f"/api{link['address']}/sessions").status_code == 201


def test_a_link_to_the_start_of_a_log_plays_or_is_shown_whole(
    ann: httpx.Client, browser: Callable[..., httpx.Client]
) -> None:
    made = ann.post("/api/sessions", json={"kind": "log", "log": uploaded(ann, 43), "playing": False}).json()
    sessions = f"/api{linked(ann, made['id'])['address']}/sessions"
    guest = browser(guest=True)
    assert guest.post(sessions).json()["playing"]
    whole = guest.post(f"{sessions}?whole=true").json()
    assert not whole["playing"]
    assert made["count"] == 43

    def index() -> int:
        return int(guest.get(f"/api/sessions/{whole['id']}").json()["index"])

    until(lambda: index() == 43)


def test_whoever_has_the_address_of_a_session_shares_its_log(
    ann: httpx.Client, browser: Callable[..., httpx.Client]
) -> None:
    session = opened(ann, uploaded(ann, 41))
    colleague, guest = browser(), browser(guest=True)  # as who opens the address that ``gridbloom upload`` prints
    link = linked(colleague, session)
    assert guest.get(f"/api{link['address']}").json()["title"] == "run.log"
    own = guest.post(f"/api{link['address']}/sessions").json()["id"]
    for client in (ann, colleague):
        listed = client.get(f"/api/sessions/{session}/links").json()["links"]
        assert [one["token"] for one in listed] == [link["token"]]
    # A guest's session shares nothing, not even for who knows the token of the service.
    assert refusal(colleague.get(f"/api/sessions/{own}/links")) == (403, "link.read_only")
    revoking = f"links/{link['token']}"
    assert refusal(colleague.delete(f"/api/sessions/{own}/{revoking}")) == (403, "link.read_only")
    assert guest.delete(f"/api/sessions/{session}/{revoking}").status_code == 401
    other = opened(colleague, uploaded(colleague, 42))
    assert refusal(colleague.delete(f"/api/sessions/{other}/{revoking}")) == (404, "link.gone")
    assert colleague.delete(f"/api/sessions/{session}/{revoking}").status_code == 204
    assert refusal(guest.get(f"/api{link['address']}")) == (404, "link.gone")
