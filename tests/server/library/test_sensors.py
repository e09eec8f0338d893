"""A log of several sensors: each can be mapped, and the others use only memory."""

from __future__ import annotations

from collections import Counter
from io import BytesIO
from pathlib import Path

import httpx
import pytest
from mcap.reader import make_reader

from mapper.core.errors import LimitError, ReadError
from mapper.sensors.joint_log import JointLog
from server.library.library import Library
from server.library.logs.records import LogNotFoundError
from server.settings import Settings
from tests.mapper.io.logs import recorded
from tests.server.library.small_logs import in_pieces
from tests.server.service import Service, running, settings_for

T0 = 1_700_000_000 * recorded.SECOND


def two_lasers() -> bytes:
    said = [recorded.scan(T0 + i, [1.0, 2.0], "/front", "front") for i in range(5)]
    said += [recorded.scan(T0 + i, [3.0, 4.0, 5.0], "/rear", "rear") for i in range(3)]
    return recorded.mcap_bytes(said)


def files(settings: Settings) -> list[Path]:
    return sorted(path for path in settings.data_dir.rglob("*") if path.is_file())


@pytest.mark.asyncio(loop_scope="module")
async def test_each_sensor_is_loaded_by_its_name(library: Library, settings: Settings) -> None:
    record = await library.put("ann", "run.mcap", in_pieces(two_lasers()))
    front = await library.load("ann", record.id)
    assert front.ranges.shape == (5, 2)
    before = files(settings)
    rear = await library.load("ann", record.id, "/rear")
    assert (rear.ranges.shape, rear.name) == ((3, 3), "run.mcap")
    assert await library.load("ann", record.id, "/rear") is rear
    assert await library.load("ann", record.id, "/front") is front, "the usual one is not read again"
    with pytest.raises(ReadError, match="no scans on '/left'") as caught:
        await library.load("ann", record.id, "/left")
    assert caught.value.code == "log.topic"
    with pytest.raises(LogNotFoundError):
        await library.load("ben", record.id, "/rear")
    assert files(settings) == before


@pytest.mark.asyncio(loop_scope="module")
async def test_several_sensors_are_loaded_as_one_log(library: Library) -> None:
    record = await library.put("ann", "run.mcap", in_pieces(two_lasers()))
    both = await library.load("ann", record.id, "/front + /rear")
    assert isinstance(both, JointLog)
    assert [(part.topic, part.n_scans, part.n_beams) for part in both.parts] == [("/front", 5, 2), ("/rear", 3, 3)]
    assert both.scan(1).ranges.tolist() == [3.0, 4.0, 5.0]
    assert await library.load("ann", record.id, "/front + /rear") is both
    with pytest.raises(ReadError, match="no scans on '/left'"):
        await library.load("ann", record.id, "/front + /left")
    with pytest.raises(LimitError, match="At most 32 sensors"):
        await library.load("ann", record.id, " + ".join(f"/s{n}" for n in range(33)))


@pytest.mark.asyncio(loop_scope="module")
async def test_all_sonars_are_one_log_where_there_is_no_lidar(library: Library) -> None:
    ring = [recorded.sonar(T0 + i, 1.0 + i % 3, f"/sonar/{i % 3}") for i in range(12)]
    record = await library.put("ann", "ring.mcap", in_pieces(recorded.mcap_bytes(ring)))
    log = await library.load("ann", record.id)
    assert isinstance(log, JointLog)
    assert [part.topic for part in log.parts] == ["/sonar/0", "/sonar/1", "/sonar/2"]
    assert log.ranges[:, 0].tolist() == [1.0, 2.0, 3.0] * 4
    one = await library.load("ann", record.id, "/sonar/1")
    assert not isinstance(one, JointLog)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory):
    shared = tmp_path_factory.mktemp("shared")
    (shared / "run.mcap").write_bytes(two_lasers())
    with running(settings_for(tmp_path_factory.mktemp("data"), logs_dir=shared)) as service:
        yield service


def test_a_session_of_another_sensor(service: Service) -> None:
    log = next(one for one in service.http.get("/api/logs").json()["logs"] if one["name"] == "run.mcap")

    def begun(topic: str | None) -> httpx.Response:
        return service.http.post("/api/sessions", json={"kind": "log", "log": log["id"], "topic": topic})

    counts = {topic: begun(topic).json()["count"] for topic in (None, "/front", "/rear")}
    assert counts == {None: 5, "/front": 5, "/rear": 3}
    refused = begun("/left")
    assert (refused.status_code, refused.json()["code"]) == (422, "log.topic")
    assert begun("x" * 8001).status_code == 422


def test_several_sensors_are_exported_and_examined_each_on_its_own_topic(service: Service) -> None:
    log = next(one for one in service.http.get("/api/logs").json()["logs"] if one["name"] == "run.mcap")
    wanted = {"kind": "log", "log": log["id"], "topic": "/front + /rear", "playing": False}
    session = service.http.post("/api/sessions", json=wanted).json()
    assert session["count"] == 8
    exported = service.http.get(f"/api/sessions/{session['id']}/run.mcap")
    assert exported.status_code == 200, exported.text
    counts = Counter(channel.topic for _, channel, _ in make_reader(BytesIO(exported.content)).iter_messages())
    assert (counts["/front"], counts["/rear"], counts["/front/points"]) == (5, 3, 5)
    examined = service.http.get(f"/api/sessions/{session['id']}/doctor")
    assert (examined.status_code, examined.json()["code"]) == (422, "doctor.short"), "of five scans the longest"


def test_the_doctor_names_the_sensor_of_each_finding(service: Service) -> None:
    said = [recorded.scan(T0 + i * recorded.SECOND // 10, [9.0] * 9, "/front", "front") for i in range(30)]
    said += [recorded.scan(T0 + i * recorded.SECOND // 10, [9.0] * 9, "/rear", "rear") for i in range(3)]
    log = service.http.put("/api/logs", params={"name": "two.mcap"}, content=recorded.mcap_bytes(said)).json()["id"]
    session = service.begin(kind="log", log=log, topic="/front + /rear", playing=False)
    examined = service.http.get(f"/api/sessions/{session}/doctor")
    assert examined.status_code == 200, examined.text
    assert ("readings.few", "/rear") in [(one["check"], one["sensor"]) for one in examined.json()["findings"]]
