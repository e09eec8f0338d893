"""A real viser server behind the proxy: what a browser receives, and what it can do."""

from __future__ import annotations

import asyncio
import gc
import os
import stat
import threading
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import httpx
import msgspec
import numpy as np
import pytest
import viser
from msgspec import Struct
from websockets.asyncio.client import connect, unix_connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.typing import Subprotocol

from mapper.mapping.parameters import LOG_ONLY, PARAMETERS
from mapper.simulation import SENSOR_PARAMETERS, WORLDS, sample_log
from server.parts.wire import command_of
from server.scenes import Scenes
from server.scenes.proxy import SUBPROTOCOL
from server.sessions import SessionHost, SessionRegistry
from server.stream.commands import MeasureCommand
from server.stream.messages import PickedMessage, PlaceMessage
from tests.server.begin import new_log, new_simulation
from tests.server.listening import listening_ports
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import Client, viser_client
from tests.server.service import PATIENCE_S, eventually
from tests.server.view import SessionView, view_of


async def changed(session: SessionHost, wanted: Callable[[SessionView], bool]) -> None:
    """Wait until ``wanted`` is true of the session's view."""
    await eventually(lambda: wanted(view_of(session)))


async def test_the_scene_shows_the_world_the_map_and_the_robot(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        for name in ("/world/solids", "/map/floor", "/robot/body/base", "/robot/beams"):
            await client.until(lambda m, name=name: m.get("name") == name)
        first = await client.until(lambda m: m["type"] == "SetPositionMessage" and m["name"] == "/robot")
        await client.until(
            lambda m: m["type"] == "SetPositionMessage" and m["name"] == "/robot" and m["position"] != first["position"]
        )
        # Columns grow out of the floor as walls become occupied.
        await client.until(lambda m: m["type"] == "MeshMessage" and m["name"].startswith("/map/"))
    assert not any("http://" in str(m) or "https://" in str(m) for m in client.seen)


def test_the_proxy_uses_the_protocol_of_the_installed_viser() -> None:
    assert f"viser-v{viser.__version__}" == SUBPROTOCOL


async def test_every_parameter_has_a_control(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        for row in (*PARAMETERS, *SENSOR_PARAMETERS):
            if row.name in LOG_ONLY:
                continue
            made = await client.until(lambda m, row=row: m.get("props", {}).get("hint") == row.sentence)
            props = made["props"]
            assert props["label"].startswith(row.label)
            assert row.unit in props["label"]
            if row.kind == "number":
                assert (props["min"], props["max"]) == (row.low, row.high)


async def test_a_slider_moves_the_parameter_and_the_parameter_the_slider(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.scenes.panel.CONFIRM_TIMEOUT_S", PATIENCE_S)  # a slow machine confirms late
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        uuid = (await client.control("Hit increment"))["uuid"]
        await client.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": 1.5})
        await changed(session, lambda view: view.config.log_odds_hit == 1.5)
        # Nothing answers a choice that the session took: an echo would fight with the hand on the slider.
        await asyncio.sleep(0.5)
        session.post(command_of({"type": "parameters", "values": {"log_odds_hit": 2.0}}))
        moved = await client.until(lambda m: m["type"] == "GuiUpdateMessage" and m["uuid"] == uuid)
        assert moved["updates"] == {"value": 2.0}
        assert view_of(session).config.log_odds_hit == 2.0


async def test_a_refused_value_snaps_back(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        uuid = (await client.control("Hit increment"))["uuid"]
        before = asdict(view_of(session).config)
        await client.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": 99.0})
        back = await client.until(lambda m: m["type"] == "GuiUpdateMessage" and m["uuid"] == uuid)
        assert back["updates"] == {"value": before["log_odds_hit"]}
        assert asdict(view_of(session).config) == before


async def test_a_click_on_the_floor_teleports(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        await client.until(lambda m: m["type"] == "ScenePointerEnableMessage")
        session.post(command_of({"type": "auto", "value": False}))
        target = next(
            (x, y) for x, y in ((5.0, 4.0), (2.0, 2.0), (8.0, 2.0), (5.0, 6.0)) if WORLDS["room"].is_free((x, y), 0.5)
        )
        origin = (target[0] - 3.0, target[1] + 4.0, 6.0)
        await client.send(
            type="ScenePointerMessage",
            event_type="click",
            ray_origin=origin,
            ray_direction=tuple((a - b) / 10.0 for a, b in zip((*target, 0.0), origin, strict=True)),
            screen_pos=((0.5, 0.5),),
            modifier=None,
        )
        await changed(session, lambda view: view.pose[:2] == pytest.approx(target, abs=1e-3))


async def test_play_and_pause(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        uuid = (await client.control("Pause"))["uuid"]
        await client.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": True})
        await changed(session, lambda view: not view.playing)
        await client.until(lambda m: m["type"] == "GuiUpdateMessage" and m["updates"].get("label") == "Play")


async def test_a_click_on_a_column_of_a_log_means_its_cell(service: Service) -> None:
    session = await new_log(service.sessions, "ann", sample_log(n_scans=40))
    told: list[Struct] = []
    pages = {name: session.join(page=name * 32) for name in ("a", "b")}
    pages["a"].send = told.append
    pages["b"].send = lambda message: pytest.fail(f"the other page was told {message}")
    session.post(command_of({"type": "pause"}))
    session.post(command_of({"type": "seek", "index": 40}))
    await changed(session, lambda view: view.index == 40)
    grid = session.model.grid
    walls = np.argwhere(grid.log_odds == grid.log_odds.max())
    x, y = max(grid.geometry.cell_to_world(walls).tolist())  # the farthest to the east
    async with viser_client(service.port, session.id, page="a" * 32) as client:
        await client.until(lambda m: m.get("name", "").startswith("/map/") and m["type"] == "MeshMessage")
        # From 4 m to the west and above: on the floor this line of sight ends 0.2 m behind the wall.
        await client.send(
            type="ScenePointerMessage",
            event_type="click",
            ray_origin=(x - 4.0, y, 4.2),
            ray_direction=(1.0, 0.0, -1.0),
            screen_pos=((0.5, 0.5),),
            modifier=None,
        )
        await eventually(lambda: bool(told))
    (picked,) = told
    assert isinstance(picked, PickedMessage)
    assert picked.what == "cell"
    row, col = grid.geometry.world_to_cell((picked.x, picked.y))
    assert grid.log_odds[row, col] > 0.0
    assert not grid.observed[tuple(grid.geometry.world_to_cell((x + 0.2, y)))], "there the floor would be met"


async def test_a_place_is_marked_in_the_views_of_the_page_that_selects_it(service: Service) -> None:
    session = await new_log(service.sessions, "ann", sample_log(n_scans=40))
    page = session.join(page="a" * 32)
    session.select(page, (1.5, -2.0))

    def is_mark(message: dict[str, Any]) -> bool:
        return (message["type"], message.get("name")) == ("LineSegmentsMessage", "/selected")

    async with (
        viser_client(service.port, session.id, page="a" * 32) as own,
        viser_client(service.port, session.id, page="b" * 32) as other,
    ):
        mark = await own.until(is_mark)
        assert mark["props"]["points"].reshape(2, 3)[:, :2].tolist() == [[1.5, -2.0]] * 2
        own.forget()
        session.select(page, (2.5, 0.0))
        mark = await own.until(is_mark)
        assert mark["props"]["points"].reshape(2, 3)[:, :2].tolist() == [[2.5, 0.0]] * 2
        session.select(page, None)
        await own.until(lambda m: m["type"] == "RemoveSceneNodeMessage" and m["name"] == "/selected")
        session.post(command_of({"type": "seek", "index": 30}))  # which both are sent
        await other.until(lambda m: m.get("name") == "/trajectory/line")
    assert not any(map(is_mark, other.seen))


async def test_a_page_that_measures_is_told_places_and_its_own_views_show_them(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room")
    session.post(command_of({"type": "pause"}))
    await changed(session, lambda view: not view.playing)
    told: list[Struct] = []
    page = session.join(page="a" * 32)
    page.send = told.append
    robot = view_of(session).pose

    async def click(client: Client, x: float, y: float) -> None:
        await client.send(
            type="ScenePointerMessage", event_type="click", ray_origin=(x, y, 5.0), ray_direction=(0.0, 0.0, -1.0),
            screen_pos=((0.5, 0.5),), modifier=None,
        )  # fmt: skip

    def nodes(client: Client, kind: str) -> list[dict[str, Any]]:
        return [m for m in client.seen if m["type"] == kind and str(m.get("name", "")).startswith("/measured/")]

    async with (
        viser_client(service.port, session.id, page="a" * 32) as own,
        viser_client(service.port, session.id, page="b" * 32) as other,
    ):
        await own.until(lambda m: m.get("name", "").startswith("/world/"))
        session.measure(page, MeasureCommand([]))
        await click(own, 2.0, 1.0)
        await eventually(lambda: bool(told))
        assert told == [PlaceMessage(2.0, 1.0, None, None)]
        session.measure(page, MeasureCommand([(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (3.0, 4.0, 0.0)], closed=True))
        await own.until(lambda m: m["type"] == "LabelMessage" and m["props"]["text"] == "5.00 m")
        assert sorted(m["props"]["text"] for m in nodes(own, "LabelMessage")) == ["3.00 m", "4.00 m", "5.00 m"]
        (lines,) = nodes(own, "LineSegmentsMessage")
        assert lines["props"]["points"].size == 4 * 2 * 3  # three sides and the stroke at the first corner
        session.measure(page, MeasureCommand())
        await own.until(lambda m: m["type"] == "RemoveSceneNodeMessage" and m["name"].startswith("/measured"))
        assert view_of(session).pose == robot
        await click(own, 2.0, 1.0)  # as before
        await changed(session, lambda view: view.pose[:2] == (2.0, 1.0))
        await other.until(lambda m: m.get("name") == "/robot")
    assert not nodes(other, "LineSegmentsMessage")
    assert len(told) == 1


async def test_a_log_has_its_path_and_a_slider_over_its_scans(service: Service) -> None:
    log = sample_log(n_scans=40)
    session = await new_log(service.sessions, "ann", log)
    session.post(command_of({"type": "pause"}))
    async with viser_client(service.port, session.id) as client:
        await client.until(lambda m: m.get("name") == "/trajectory")
        scans = await client.control("Scans in the map")
        assert scans["props"]["max"] == 40
        await client.send(type="GuiUpdateMessage", uuid=scans["uuid"], updates={"value": 25})
        await changed(session, lambda view: view.index == 25)
        # A click goes to the moment nearest to that place.
        x, y, _ = log.trajectory().poses[9].tolist()
        await client.send(
            type="ScenePointerMessage",
            event_type="click",
            ray_origin=(x, y, 5.0),
            ray_direction=(0.0, 0.0, -1.0),
            screen_pos=((0.5, 0.5),),
            modifier=None,
        )
        await changed(session, lambda view: view.index == 10)
        choice = await client.control("Trajectory")
        await client.send(type="GuiUpdateMessage", uuid=choice["uuid"], updates={"value": "odometry"})
        await eventually(lambda: session.model.recording.trajectory == "odometry")
        poses = log.trajectory("odometry").poses
        path = await client.until(
            lambda m: (
                m.get("name") == "/trajectory/line"
                and m["type"] == "LineSegmentsMessage"
                and np.allclose(m["props"]["points"].reshape(-1, 2, 3)[:, 0, :2], poses[:-1, :2], atol=1e-4)
            )
        )
        assert len(path["props"]["points"]) == 6 * (len(poses) - 1)


async def test_another_world_has_other_walls(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        first = await client.until(lambda m: m["type"] == "MeshMessage" and m["name"] == "/world/solids")
        choice = await client.control("World")
        await client.send(type="GuiUpdateMessage", uuid=choice["uuid"], updates={"value": "office"})
        await client.until(lambda m: m["type"] == "MeshMessage" and m["name"] == "/world/solids" and m is not first)


# -- the proxy -----------------------------------------------------------------------------------------------------


async def test_the_page(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    base = f"http://127.0.0.1:{service.port}"
    async with httpx.AsyncClient(base_url=base) as http:
        page = await http.get(f"/scenes/{session.id}/")
        assert page.status_code == 200
        assert "Gridbloom" in page.text
        assert page.headers["content-encoding"] == "gzip"
        policy = page.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'self'" in policy
        assert f"ws://127.0.0.1:{service.port}" in policy
        assert "http:" not in policy.replace("https:", "")
        again = await http.get(f"/scenes/{session.id}/", headers={"If-None-Match": page.headers["etag"]})
        assert again.status_code == 304
        assert (await http.head(f"/scenes/{session.id}/")).status_code == 200
        plain = await http.get(f"/scenes/{session.id}/", headers={"Accept-Encoding": "identity"})
        assert plain.text == page.text
        bare = await http.get(f"/scenes/{session.id}")
        assert (bare.status_code, bare.headers["location"]) == (308, f"/scenes/{session.id}/")
        for path in ("etc/passwd", "../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "index.html"):
            assert (await http.get(f"/scenes/{session.id}/{path}")).status_code == 404
        for method in ("POST", "PUT", "DELETE"):
            assert (await http.request(method, f"/scenes/{session.id}/")).status_code == 405
    assert len(service.scenes) == 0, "the page alone makes no scene"


async def test_a_client_of_another_version_is_refused(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    url = f"ws://127.0.0.1:{service.port}/scenes/{session.id}"
    for protocols in (None, [Subprotocol("viser-v0.0.1")], [Subprotocol("gridbloom.v3")]):
        with pytest.raises((InvalidStatus, ConnectionClosed)):
            async with connect(url, subprotocols=protocols) as socket:
                await socket.recv()


async def test_the_viser_server_listens_on_a_private_unix_socket_only(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    before = listening_ports(os.getpid())
    scene = await service.scenes.get(session)
    assert listening_ports(os.getpid()) == before
    assert scene.path.is_socket()
    assert stat.S_IMODE(scene.path.parent.stat().st_mode) == 0o700
    # viser would serve its files there.
    transport = httpx.AsyncHTTPTransport(uds=str(scene.path))
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as http:
        assert (await http.get("/index.html")).status_code == 426


async def test_no_tunnel_is_opened_even_past_the_proxy(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *arguments: opened.append(arguments))
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    scene = await service.scenes.get(session)
    asked = threading.Event()
    ask = scene._server.request_share_url

    def asking() -> None:
        ask()
        asked.set()

    monkeypatch.setattr(scene._server, "request_share_url", asking)
    async with unix_connect(str(scene.path), subprotocols=[Subprotocol(SUBPROTOCOL)], compression=None) as socket:
        await socket.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
        await eventually(asked.is_set)
    assert opened == []


async def test_a_closed_session_closes_the_browsers_socket(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        await client.control("Hit increment")
        await service.sessions.close(session.id)
        with pytest.raises(ConnectionClosed):
            await client.until(lambda _: False)
    assert len(service.scenes) == 0


async def test_messages_that_a_scene_does_not_need_stay_outside(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    scene = await service.scenes.get(session)
    async with viser_client(service.port, session.id) as client:
        uuid = (await client.control("Hit increment"))["uuid"]
        await client.send(type="ShareUrlRequest")
        await client.send(type="GuiUpdateMessage", uuid=uuid, updates={"sync_cb": "x", "value": 1.0})
        await client.send(type="FileTransferStartUpload", source_component_uuid=uuid)
        await client.socket.send(b"\xff\xff\xff")
        # What comes after is carried out, and nothing of the above was.
        await client.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": 1.25})
        await changed(session, lambda view: view.config.log_odds_hit == 1.25)
        assert scene._server._share_tunnel is None
        await client.socket.send(b"x" * 20_000)
        with pytest.raises(ConnectionClosed) as caught:
            await client.until(lambda _: False)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009


# -- the life of scenes --------------------------------------------------------------------------------------------


async def test_no_work_without_a_browser(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, session.id) as client:
        await client.control("Hit increment")
        assert session.watched
    await changed(session, lambda _: not session.listeners)
    assert not session.watched


async def test_scenes_without_a_browser_are_closed(sessions: SessionRegistry) -> None:
    scenes = Scenes(check_s=0.05)
    session = await new_simulation(sessions, "ann", "room", seed=1)
    one, two = await asyncio.gather(scenes.get(session), scenes.get(session))
    assert one is two
    one.enter()
    scenes._idle_s = 0.05
    await asyncio.sleep(0.3)
    assert len(scenes) == 1
    one.leave()
    await eventually(lambda: len(scenes) == 0)
    again = await scenes.get(session)
    assert again is not one
    await scenes.close()


async def test_ten_scenes_leave_nothing_behind(sessions: SessionRegistry) -> None:
    def counts() -> tuple[int, int]:
        gc.collect()
        shared = ("asyncio", "session")  # the pools of the loop and of the sessions grow to their size and stay
        threads = [thread for thread in threading.enumerate() if not thread.name.startswith(shared)]
        return len(threads), len(list(Path("/proc/self/fd").iterdir()))

    scenes = Scenes()
    session = await new_simulation(sessions, "ann", "room", seed=1)
    await scenes.get(session)
    await scenes.close()
    before = counts()
    for _ in range(10):
        scenes = Scenes()
        scene = await scenes.get(session)
        path = scene.path
        scene.enter()
        await asyncio.sleep(0.05)
        await scenes.close()
        assert not path.parent.exists()
    await eventually(lambda: all(now <= then for now, then in zip(counts(), before, strict=True)))
