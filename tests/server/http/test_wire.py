"""Real sessions send every message that is stated, and no other (checked by Watcher)."""

from __future__ import annotations

import asyncio
from typing import get_args

import pytest

from server.parts.wire import ServerMessage
from server.sessions.commands import MeasureRay
from tests.server.service import Service, Watcher, once_read


async def messages_of_a_world(service: Service) -> set[str]:
    session_id = service.begin(kind="simulation", world="room", seed=8)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.settle()
        await watcher.send("why", row=60, col=60, epoch=watcher.epoch)
        await watcher.answer("why")
        await watcher.send("costmap", value=True)
        await watcher.send("cost", x=5.0, y=5.0)
        await watcher.answer("cost")
        await watcher.send("nav2", text=None)
        await watcher.answer("nav2")
        await watcher.send("costmap", value=False)
        await watcher.send("parameters", values={"window": "wide"})
        await watcher.answer("error")
        await watcher.send("teleport", x=-50.0, y=-50.0)
        await watcher.answer("notice")
        await watcher.send("faults", values={"drift": True, "specular": True})
        await watcher.send("compare", values={"clamp": False})
        await watcher.send("sensor", values={"kind": "sonar_ring"})
        await watcher.send("edit", added=[["wall", 100, 100, 200, 100], ["box", 300, 300, 350, 350]], erased=[])
        await watcher.answer("world")
        await watcher.send("edit", added=[], erased=[], watch=True)
        await watcher.answer("forgetting")
        await watcher.send("ping", id=1)
        await watcher.answer("pong")
        await watcher.send("play")
        of_a_drifting_sonar = {"believed_pose", "believed_scan_pose", "beam_width"}
        await watcher.until(lambda: of_a_drifting_sonar <= set(watcher.newest["frame"]))
        async with service.connect(session_id) as second_socket:
            second = Watcher(second_socket, layer="second_map")
            await second.until(lambda: second.frames > 0)
        return set(watcher.newest) | set(second.newest)


async def messages_of_a_log(service: Service) -> set[str]:
    session_id = await asyncio.to_thread(service.begin, kind="log", log="sample-office")
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.send("pause")
        await watcher.send("seek", index=20)
        await watcher.until(lambda: watcher.newest.get("frame", {"index": 0})["index"] == 20)
        answer = await asyncio.to_thread(
            service.http.put, f"/api/sessions/{session_id}/compare", json={"trajectory": "odometry"}
        )
        assert answer.status_code < 300, answer.text
        await watcher.until(lambda: (watcher.newest.get("comparison") or {}).get("numbers") is not None)
        await watcher.settle()
        await watcher.send("why", row=10, col=10, epoch=watcher.epoch)
        await watcher.answer("why")
        poses = (await asyncio.to_thread(service.http.get, f"/api/sessions/{session_id}/trajectory.tum")).text
        added = await asyncio.to_thread(service.http.put, "/api/logs/sample-office/trajectories/mine", content=poses)
        assert added.status_code < 300, added.text
        await watcher.answer("trajectories")
        note = {"text": "the door", "x": 1.0, "y": 2.0}
        await asyncio.to_thread(service.http.post, f"/api/sessions/{session_id}/notes", json=note)
        await watcher.answer("notes")
        sessions = service.state.sessions
        session = sessions.get(session_id)
        clicked = session.model.on_scene_ray((1.0, 1.0, 5.0), (0.0, 0.0, -1.0))  # as the 3D view hands it over
        assert clicked is not None
        sessions.loop.call_soon_threadsafe(lambda: session.post(clicked, *session.hub.clients))
        await watcher.answer("picked")
        measured = MeasureRay((1.0, 1.0, 5.0), (0.0, 0.0, -1.0), None)
        sessions.loop.call_soon_threadsafe(lambda: session.post(measured, *session.hub.clients))
        await watcher.answer("place")
        await asyncio.to_thread(service.http.post, f"/scenes/{session_id}/settings", json={"height": 2.0})
        await watcher.answer("scene")
        return set(watcher.newest)


async def messages_of_an_edited_map(service: Service) -> set[str]:
    world = await asyncio.to_thread(service.begin, kind="simulation", world="room", playing=False)
    answer = await asyncio.to_thread(service.http.post, f"/api/sessions/{world}/kept-map", json={"name": "Room"})
    return await messages_of_an_upload(service, answer.json()["id"], "map_edits", kind="log")


async def messages_of_a_volume(service: Service) -> set[str]:
    head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\n"
    cloud = f"{head}VIEWPOINT 0 0 2 1 0 0 0\nDATA ascii\n0 0 0\n0.5 0 0\n0 0.5 1\n".encode()
    answer = await asyncio.to_thread(service.http.put, "/api/logs", params={"name": "cloud.pcd"}, content=cloud)
    return await messages_of_an_upload(service, answer.json()["id"], "volume", kind="volume")


async def messages_of_an_upload(service: Service, log: str, awaited: str, kind: str) -> set[str]:
    await asyncio.to_thread(once_read, service.http, log)
    async with service.connect(await asyncio.to_thread(service.begin, kind=kind, log=log)) as socket:
        watcher = Watcher(socket)
        await watcher.answer(awaited)
        if kind == "volume":
            await watcher.send("voxel", x=0.0, y=0.0, z=0.0)
            await watcher.answer("voxel")
            await watcher.send("volume_look", values={"show": "surface"})
            await watcher.send("voxel_ray", origin=[0.0, 0.0, 2.0], direction=[0.0, 0.0, -1.0])
            await watcher.answer("surface_voxel")
        return set(watcher.newest)


async def test_every_message_is_as_it_is_stated(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.sessions.computation.SHOWN_AFTER_S", 0.0)  # whatever is computed is shown
    seen = await messages_of_a_world(service) | await messages_of_a_log(service)
    seen |= await messages_of_an_edited_map(service) | await messages_of_a_volume(service)
    assert seen == {cls.__struct_config__.tag for cls in get_args(ServerMessage)}
