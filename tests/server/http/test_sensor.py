"""Another sensor of a log, and other cuts of its clouds, in a session that goes on."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from mapper.io.logs import open_robot_log
from mapper.io.logs.selection import Selection
from mapper.sensors.planar.options import PlanarCut
from server.sessions.parts import Recording
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.server.service import PATIENCE_S, Service, Watcher, once_read, running, settings_for

#: Above the floor and below the ceiling of the room, in a quarter of a circle.
WALLS = {"min_height": 0.3, "max_height": 2.0, "angle_min": 0.0, "angle_max": math.pi / 2}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
        yield service


@pytest.fixture(scope="module")
def recording() -> bytes:
    """A lidar of twenty scans and, beside it, clouds of a room."""
    clouds = recording_of_room(n=4)
    first = min(one.stamp_ns for one in clouds)
    lidar = [recorded.scan(first + n * 15_000_000, [1.0, 2.0, 3.0], frame="velodyne") for n in range(20)]
    return recorded.mcap_bytes([*lidar, *clouds])


def uploaded(service: Service, content: bytes) -> str:
    log_id = str(service.http.put("/api/logs", params={"name": "run.mcap"}, content=content).json()["id"])
    assert once_read(service.http, log_id)["state"] == "ready"
    return log_id


def sensor(http: httpx.Client, session: str, **wanted: Any) -> httpx.Response:
    return http.put(f"/api/sessions/{session}/sensor", json=wanted)


async def test_the_clouds_beside_a_lidar_are_mapped_and_cut_again(
    service: Service, recording: bytes, tmp_path: Any
) -> None:
    log_id = await asyncio.to_thread(uploaded, service, recording)
    session = service.begin(kind="log", log=log_id, playing=False)
    path = tmp_path / "run.mcap"
    path.write_bytes(recording)

    def expected(cut: PlanarCut) -> np.ndarray:
        log = open_robot_log(path, selection=Selection(("/points",), cut)).first
        return np.asarray(log.ranges[log.n_scans - 1])

    def shown() -> np.ndarray:
        recording = service.state.sessions.get(session).model.find(Recording)
        assert recording is not None
        return np.asarray(recording.log.ranges[-1])

    async with service.connect(session) as socket:
        watcher = Watcher(socket)
        await watcher.send("seek", index=20)
        await watcher.until(lambda: watcher.newest.get("frame", {}).get("index") == 20)
        assert (watcher.newest["hello"]["log"]["topic"], watcher.newest["hello"]["log"]["cut"]) == ("/scan", None)
        await watcher.send("parameters", values={"log_odds_hit": 1.25})
        await watcher.answer("parameters")
        answer = await asyncio.to_thread(sensor, service.http, session, topic="/points")
        assert answer.status_code == 200, answer.text
        await watcher.until(lambda: watcher.newest["hello"]["log"]["topic"] == "/points")
        # The whole log was in the map, and is again; what was set stays set.
        await watcher.until(lambda: (watcher.newest["frame"]["index"], watcher.newest["frame"]["count"]) == (4, 4))
        assert watcher.newest["parameters"]["values"]["log_odds_hit"] == 1.25
        told = watcher.newest["hello"]["log"]["cut"]
        assert told["values"]["min_height"] == 0.0
        assert "scan_height" not in told["values"], "which is for images"
        np.testing.assert_array_equal(shown(), expected(PlanarCut()))
        answer = await asyncio.to_thread(sensor, service.http, session, topic="/points", cut=WALLS)
        assert answer.status_code == 200, answer.text
        await watcher.until(lambda: watcher.newest["hello"]["log"]["cut"]["values"]["max_height"] == 2.0)
        np.testing.assert_array_equal(shown(), expected(PlanarCut.of(WALLS)))
        assert len(shown()) == 90

    # A link to the view has the cut as well, and its guests cannot change it.
    link = service.http.post(f"/api/sessions/{session}/links", json={}).json()
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S) as guest:
        shared = (await guest.post(f"/api/shared/{link['token']}/sessions")).json()["id"]
        found = service.state.sessions.get(shared).model.find(Recording)
        assert found is not None
        assert (found.view().topic, found.view().cut) == ("/points", WALLS)
        refused = await guest.put(f"/api/sessions/{shared}/sensor", json={"topic": None})
        assert (refused.status_code, refused.json()["code"]) == (403, "link.read_only")


@pytest.mark.parametrize(
    ("wanted", "code"),
    [
        ({"topic": "/nothing"}, "log.topic"),
        ({"topic": "/points", "cut": {"min_height": 2.0, "max_height": 1.0}}, "cut.heights"),
        ({"topic": "/points", "cut": {"no_such": 1.0}}, "cut.unknown"),
        ({"topic": "/points", "cut": {"angle_min": 9.0}}, "parameter.angle_min"),
    ],
)
def test_what_is_refused_changes_nothing(service: Service, recording: bytes, wanted: Any, code: str) -> None:
    session = service.begin(kind="log", log=uploaded(service, recording), playing=False)
    refused = sensor(service.http, session, **wanted)
    assert (refused.status_code, refused.json()["code"]) == (422, code)
    assert service.http.get(f"/api/sessions/{session}").json()["count"] == 20
    service.end_sessions()


def test_a_session_begins_with_a_cut(service: Service, recording: bytes) -> None:
    log_id = uploaded(service, recording)
    session = service.begin(kind="log", log=log_id, topic="/points", cut=WALLS, playing=False)
    found = service.state.sessions.get(session).model.find(Recording)
    assert found is not None
    assert found.log.n_beams == 90
    service.end_sessions()
