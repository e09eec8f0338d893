"""The stream over a real socket: what a browser receives, and the errors that it can cause."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

from mapper.io.maps import pgm_bytes
from mapper.mapping.parameters import LOG_ONLY
from mapper.simulation import WORLDS
from server.http.stream_connection import COMMAND_BURST, COMMANDS_PER_S, exchange
from server.stream.messages import Pong
from tests.server.service import PATIENCE_S, Service, Watcher, until_closed
from tests.server.view import view_of


def session_of(service: Service, session_id: str) -> Any:
    return service.state.sessions.get(session_id)


def expected_log_odds(service: Service, session_id: str) -> Any:
    """The session's own grid as a client should see it, to half a step of the int8 picture."""
    view = view_of(session_of(service, session_id))
    low, high = view.config.clamp_limits
    return np.where(view.observed, np.clip(view.log_odds, low, high), np.nan)


async def test_a_session_streams_its_map(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.frames > 10)
        await watcher.settle()
        assert watcher.messages[0]["type"] == "hello"
        assert {"hello", "layers", "geometry", "world", "parameters"} <= {m["type"] for m in watcher.messages}
        np.testing.assert_allclose(watcher.log_odds(), expected_log_odds(service, session_id), atol=5.5 / 254 + 1e-6)
        frame = watcher.newest["frame"]
        assert len(frame["ranges"]) == 360
        assert WORLDS["room"].is_free(frame["pose"][:2])
        hello = watcher.newest["hello"]
        assert hello["kind"] == "simulation"
        # A session that nobody has touched differs in nothing from what its table calls initial.
        first = {row["name"]: row["initial"] for row in hello["parameters"]["table"]}
        assert first == {name: value for name, value in hello["parameters"]["values"].items() if name not in LOG_ONLY}
        # A scan is sent once, however many frames show it.
        frames, scans = watcher.frames, watcher.scans
        await watcher.send("parameters", values={"log_odds_hit": 0.3})
        await watcher.until(lambda: watcher.frames > frames)
        await watcher.settle()
        assert watcher.scans == scans >= 1


async def test_every_kind_of_change_reaches_the_picture(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="room", seed=8)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        for values in (
            {"window": 0.5},
            {"log_odds_hit": 0.3, "log_odds_miss": -1.0},
            {"resolution": 0.1},
            {"log_odds_min": -5.0, "log_odds_max": 6.0},
            {"model": "step_window", "update": "per_scan"},
            {"range_max": 2.0},
        ):
            await watcher.send("parameters", values=values)
            answer = await watcher.answer("parameters")
            while any(answer["values"][name] != value for name, value in values.items()):
                answer = await watcher.answer("parameters")
            await watcher.settle()
            geometry = watcher.newest["geometry"]
            step = (geometry["high"] - geometry["low"]) / 254
            expected = expected_log_odds(service, session_id)
            np.testing.assert_allclose(watcher.log_odds(), expected, atol=step + 1e-6)
            assert watcher.newest["frame"]["remade_ms"] > 0
        await watcher.send("world", name="maze")
        await watcher.answer("world")
        await watcher.settle()
        np.testing.assert_allclose(watcher.log_odds(), expected_log_odds(service, session_id), atol=11 / 254)


async def test_a_teleport_brings_new_cells_around_the_new_place(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="office", seed=8)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.settle()
        before = watcher.picture != -128
        await watcher.send("teleport", x=17.0, y=12.0)
        await watcher.until(lambda: watcher.newest["frame"]["pose"][0] > 15.0)
        await watcher.settle()
        g = watcher.newest["geometry"]
        x, y = watcher.newest["frame"]["pose"][:2]
        col, row = int((x - g["origin"][0]) / g["resolution"]), int((y - g["origin"][1]) / g["resolution"])
        new = (watcher.picture != -128) & ~before
        assert new[row - 20 : row + 20, col - 20 : col + 20].sum() > 100


async def test_a_teleport_into_a_wall_reports_the_actual_pose(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.send("teleport", x=-50.0, y=-50.0)
        notice = await watcher.answer("notice")
        assert notice["code"] == "teleport.moved"
        assert "Outside the map" in notice["message"]


async def test_inspect_reads_one_cell(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.settle()
        row, col = (int(v) for v in np.argwhere(watcher.picture == watcher.picture.max())[0])
        await watcher.send("inspect", row=row, col=col, epoch=watcher.epoch)
        cell = await watcher.answer("cell")
        assert cell["observed"]
        assert cell["state"] == "occupied"
        assert cell["p_occ"] == pytest.approx(1 / (1 + np.exp(-cell["log_odds"])))
        assert cell["log_odds"] == pytest.approx(watcher.log_odds()[row, col], abs=5.5 / 254)
        g = watcher.newest["geometry"]
        assert cell["x"] == pytest.approx(g["origin"][0] + (col + 0.5) * g["resolution"])
        assert cell["y"] == pytest.approx(g["origin"][1] + (row + 0.5) * g["resolution"])


async def test_a_client_that_resumes_gets_only_new_tiles(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="office", seed=1)
    async with service.connect(session_id) as socket:
        first = Watcher(socket)
        await first.settle()
        told = {"epoch_id": first.newest["hello"]["epoch_id"], "epoch": first.epoch, "revision": first.revision}
        told["layer"] = "map"
        kept = first.picture.copy()
    async with service.connect(session_id) as socket:
        again = Watcher(socket)
        await again.send("resume", **told)
        again.epoch, again.picture = first.epoch, kept
        await again.send("step", scans=5)
        await again.until(
            lambda: again.newest.get("frame", {"index": 0})["index"] == first.newest["frame"]["index"] + 5
        )
        await again.settle()
        expected = expected_log_odds(service, session_id)
        np.testing.assert_allclose(again.log_odds(), expected, atol=5.5 / 254 + 1e-6)


async def test_a_second_map_is_added_and_removed_on_the_same_socket(service: Service) -> None:
    session_id = service.begin(kind="simulation", world="room", seed=8)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.send("subscribe", layers=["map", "second_map"])  # of which there is only one yet
        await watcher.until(lambda: watcher.complete)
        assert [one["name"] for one in watcher.newest["layers"]["layers"]] == ["map"]
        await watcher.send("compare", values={"log_odds_hit": 0.2})
        await watcher.until(lambda: len(watcher.newest["layers"]["layers"]) == 2)
        number = watcher.newest["layers"]["layers"][1]["id"]
        await watcher.until(lambda: watcher.of_other_layers.get(number, 0) > 0)
        second = watcher.newest["geometry"]
        assert second["layer"] == number
        await watcher.send("inspect", row=60, col=60, epoch=second["epoch"], layer="third_map")
        assert (await watcher.answer("error"))["code"] == "command.layer"
        await watcher.send("compare", values=None)
        await watcher.until(lambda: len(watcher.newest["layers"]["layers"]) == 1)
        await watcher.settle()
        np.testing.assert_allclose(watcher.log_odds(), expected_log_odds(service, session_id), atol=5.5 / 254 + 1e-6)


async def test_two_browsers_share_one_session(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket, service.connect(session_id) as other_socket:
        one, other = Watcher(socket), Watcher(other_socket)
        await one.send("parameters", values={"window": 0.3})
        while (await other.answer("parameters"))["values"]["window"] != 0.3:
            pass
        await one.send("parameters", values={"window": -3})
        assert (await one.answer("error"))["code"] == "parameter.window"
        await one.settle()
        await other.settle()
        assert not [m for m in other.messages if m["type"] == "error"]
        assert one.picture.tobytes() == other.picture.tobytes()


MALFORMED: list[tuple[Any, str]] = [
    (b"\x01\x02", "command.binary"),
    ('{"type":"teleport","x":1', "command.json"),
    ('{"type":"teleport","x":NaN,"y":1}', "command.number"),
    ('{"type":"teleport","x":1e999,"y":1}', "command.x"),
    ('{"type":"teleport","x":' + "1" * 400 + ',"y":1}', "command.x"),
    ('{"type":"play","padding":"' + "x" * 100_000 + '"}', "command.too_long"),
    ('{"type":"unheard of"}', "command.unknown"),
    ('{"type":["play"]}', "command.type"),
    ("null", "command.type"),
    ('{"type":"ack"}', "command.seq"),
    ('{"type":"ack","seq":1000000}', "command.seq"),
    ('{"type":"ack","seq":"1"}', "command.seq"),
    ('{"type":"resume","epoch_id":5}', "command.epoch_id"),
    ('{"type":"resume","epoch_id":"x","epoch":1,"revision":1}', "command.layer"),
    ('{"type":"subscribe"}', "command.layers"),
    ('{"type":"subscribe","layers":[1]}', "command.layers"),
    ('{"type":"subscribe","layers":["' + '","'.join("x" * 65) + '"]}', "command.layers"),
    ('{"type":"speed"}', "command.value"),
    ('{"type":"parameters","values":{"window":"wide"}}', "parameter.window"),
    ('{"type":"parameters","values":{"__class__":1}}', "parameter.unknown"),
]


@pytest.mark.parametrize(("sent", "code"), MALFORMED)
async def test_a_malformed_frame_is_answered_with_an_error_and_the_session_continues(
    service: Service, sent: str | bytes, code: str
) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.frames > 2)
        await socket.send(sent)
        error = await watcher.answer("error")
        assert error["code"] == code
        assert set(error) == {"type", "code", "message", "detail"}
        assert len(error["message"]) < 300
        frames = watcher.frames
        await watcher.send("ping", id=7)
        assert (await watcher.answer("pong"))["id"] == 7
        await watcher.until(lambda: watcher.frames > frames + 2)


async def test_too_many_malformed_frames_end_the_connection_and_nothing_else(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket, service.connect(session_id) as good_socket:
        good = Watcher(good_socket)
        for _ in range(30):
            await socket.send("}{")
        await until_closed(socket)
        assert socket.close_code == 1008
        frames = good.frames
        await good.until(lambda: good.frames > frames + 5)


async def test_a_text_that_is_too_long_for_a_frame_ends_only_that_connection(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        await socket.send("x" * (2 << 20))
        await until_closed(socket)
        assert socket.close_code == 1009
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.frames > 2)


async def test_a_flood_of_commands_slows_only_its_sender(service: Service) -> None:
    session_id, other_id = service.begin(), service.begin()
    async with service.connect(session_id, close_timeout=0.5) as socket, service.connect(other_id) as other_socket:
        other = Watcher(other_socket)
        session, began = session_of(service, session_id), time.monotonic()
        before = session.model.progress[0]
        flood = [json.dumps({"type": "teleport", "x": 1.0 + i % 5, "y": 2.0}) for i in range(2000)]

        async def pour() -> None:
            for command in flood:
                await socket.send(command)

        pouring = asyncio.create_task(pour())
        await other.until(lambda: other.frames > 30)
        # Each teleport is a scan, and as it walks there are ten in a second.
        scans, seconds = session.model.progress[0] - before, time.monotonic() - began
        assert scans <= COMMAND_BURST + (COMMANDS_PER_S + 10.0) * seconds + 10
        pouring.cancel()
        await asyncio.gather(pouring, return_exceptions=True)


async def test_a_flood_without_end_ends_the_connection(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.http.stream_connection.MAX_THROTTLED", 30)
    monkeypatch.setattr("server.stream.hub.ACK_TIMEOUT_S", PATIENCE_S)  # nothing is acknowledged here
    async with service.connect(service.begin()) as socket:
        for _ in range(1000):
            await socket.send('{"type":"ping","id":1}')
        await until_closed(socket)
        assert (socket.close_code, socket.close_reason) == (1008, "too many commands")


async def test_what_comes_for_a_client_whose_connection_was_just_closed_is_no_failure(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures: list[object] = []
    ended = threading.Event()

    async def flooded(websocket: Any, _: object, client: Any, *__: object) -> None:
        await websocket.close(1008, "too many commands")
        client.send(Pong(1, 0.0))
        sending = [task for task in asyncio.all_tasks() if task.get_name() == "stream out"]
        await asyncio.wait(sending, return_when=asyncio.FIRST_COMPLETED)

    async def watched(*arguments: Any, page: str) -> None:
        try:
            await exchange(*arguments, page=page)
        finally:
            ended.set()

    log = SimpleNamespace(error=lambda *_, exc_info: failures.append(exc_info))
    monkeypatch.setattr("server.http.stream_connection._log", log)
    monkeypatch.setattr("server.http.stream_connection._receive", flooded)
    monkeypatch.setattr("server.http.stream_connection.exchange", watched)
    async with service.connect(service.begin()) as socket:
        await until_closed(socket)
        assert socket.close_code == 1008
    assert await asyncio.to_thread(ended.wait, PATIENCE_S)
    assert failures == []


async def test_the_subprotocol_is_required(service: Service) -> None:
    async with connect(service.address(service.begin()), compression=None) as socket:
        await until_closed(socket)
        assert socket.close_code == 1008


async def test_the_socket_of_an_unknown_session_is_closed_with_its_reason(service: Service) -> None:
    async with service.connect("nothing") as socket:
        await until_closed(socket)
        assert (socket.close_code, socket.close_reason) == (4404, "session.unknown")


async def test_the_socket_of_an_ended_session_is_closed_with_its_reason(service: Service) -> None:
    session_id = service.begin()
    async with service.connect(session_id) as socket:
        await asyncio.wait_for(socket.recv(), PATIENCE_S)
        answer = await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")
        assert answer.status_code == 204
        await until_closed(socket)
        assert socket.close_code == 4410


async def test_a_page_of_an_older_protocol_hears_of_the_newer_one(service: Service) -> None:
    older = Subprotocol("gridbloom.v2")
    async with connect(service.address(service.begin()), subprotocols=[older]) as socket:
        assert socket.subprotocol == older
        hello = json.loads(await asyncio.wait_for(socket.recv(), PATIENCE_S))
        assert (hello["type"], hello["protocol"]) == ("hello", "gridbloom.v3")
        await until_closed(socket)
        assert socket.close_code == 1008


async def test_the_stream_is_not_compressed_twice(service: Service) -> None:
    async with connect(service.address(service.begin()), subprotocols=["gridbloom.v3"]) as socket:  # type: ignore[list-item]
        assert socket.subprotocol == "gridbloom.v3"
        assert "Sec-WebSocket-Extensions" not in socket.response.headers  # type: ignore[union-attr]


async def test_a_log_plays_and_its_end_is_its_map_file(service: Service) -> None:
    session_id = await asyncio.to_thread(service.begin, kind="log", log="sample-office")
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.newest.get("frame", {"index": 0})["index"] > 3)
        hello = watcher.newest["hello"]
        assert [t["name"] for t in hello["log"]["trajectories"]] == ["true", "odometry"]
        assert len(watcher.newest["trajectory"]["poses"]) == hello["log"]["n_scans"]
        await watcher.send("seek", index=hello["log"]["n_scans"])
        await watcher.until(lambda: watcher.newest["frame"]["index"] == hello["log"]["n_scans"])
        await watcher.settle()
        image = (await asyncio.to_thread(service.http.get, f"/api/sessions/{session_id}/map.pgm")).content
        assert image == pgm_bytes(await asyncio.to_thread(lambda: session_of(service, session_id).model.grid))
        rows, cols = watcher.picture.shape
        shades = np.frombuffer(image[-rows * cols :], dtype=np.uint8).reshape(rows, cols)[::-1]
        assert (shades[watcher.picture == -128] == 205).all()
        assert (watcher.log_odds()[shades == 0] > 0.6).all()
        assert (watcher.log_odds()[shades == 254] < -1.0).all()
