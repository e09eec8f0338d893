"""Trajectories added to logs over HTTP: open sessions get them, links show them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import httpx
import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore

from server.sessions.parts import Recording
from tests.server.library.small_logs import carmen, tum
from tests.server.service import PATIENCE_S, Service, Watcher, once_read, running, settings_for


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
        yield service


def put(http: httpx.Client, log_id: str, name: str, text: bytes) -> httpx.Response:
    return http.put(f"/api/logs/{log_id}/trajectories/{name}", content=text)


def test_it_is_put_read_mapped_shared_and_deleted(service: Service) -> None:
    http = service.http
    log_id = http.put("/api/logs", params={"name": "run.log"}, content=carmen(12)).json()["id"]
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    answer = put(http, log_id, "from LaMa", tum(10, y=2.0, start=1))
    assert answer.status_code == 201, answer.text
    assert answer.json()["notes"] == [
        "2 scans lie before the first or after the last pose: the log’s own poses continue the trajectory."
    ]
    assert [one["name"] for one in http.get(f"/api/logs/{log_id}").json()["trajectories"]][-1] == "from LaMa"
    got = http.get(f"/api/logs/{log_id}/trajectories/from LaMa")
    assert got.content == tum(10, y=2.0, start=1)
    assert got.headers["content-disposition"] == 'attachment; filename="from_LaMa.tum"'

    async def choose() -> list[str]:
        async with service.connect(session) as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: "trajectory" in watcher.newest)
            await watcher.send("trajectory", name="from LaMa")
            await watcher.until(lambda: watcher.newest["trajectory"]["name"] == "from LaMa")
            return [one["name"] for one in watcher.newest["trajectories"]["trajectories"]]

    assert asyncio.run(choose()) == ["scan", "from LaMa"], "the open session has it"
    lines = http.get(f"/api/sessions/{session}/trajectory.tum").text.splitlines()
    assert [float(line.split()[2]) for line in lines] == [2.0] * 12
    assert http.put(f"/api/sessions/{session}/compare", json={"trajectory": "scan"}).status_code == 200
    examined = http.get(f"/api/sessions/{session}/doctor")
    assert examined.json().get("trajectory") == "from LaMa", examined.text
    token = http.post(f"/api/sessions/{session}/links", json={}).json()["token"]
    with httpx.Client(base_url=http.base_url, timeout=PATIENCE_S) as guest:
        shared = guest.post(f"/api/shared/{token}/sessions").json()["id"]
        recording = service.state.sessions.get(shared).model.find(Recording)
        assert recording is not None
        assert recording.trajectory == "from LaMa"
        assert guest.get(f"/api/logs/{log_id}/trajectories/from LaMa").status_code == 404

    deleted = http.delete(f"/api/logs/{log_id}/trajectories/from LaMa")
    assert deleted.status_code == 204
    assert http.get(f"/api/sessions/{session}/trajectory.tum").text.splitlines() == lines, "the open session goes on"
    assert http.delete(f"/api/logs/{log_id}/trajectories/from LaMa").json()["code"] == "trajectory.not_found"
    refused = put(http, log_id, "scan", tum(6))
    assert (refused.status_code, refused.json()["code"]) == (422, "trajectory.name")


def test_whoever_has_the_address_of_a_session_adds_to_its_log(service: Service) -> None:
    http = service.http
    log_id = http.put("/api/logs", params={"name": "run.log"}, content=carmen(13)).json()["id"]
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    # As long as a real one: a request that is not an upload has at most 64 KiB.
    long = tum(13, y=3.0) + (b"# " + b"." * 97 + b"\n") * 1000
    with httpx.Client(base_url=http.base_url, timeout=PATIENCE_S) as colleague:
        assert put(colleague, log_id, "theirs", long).status_code == 404
        address = f"/api/sessions/{session}/trajectories/theirs"
        answer = colleague.put(address, content=long)
        assert answer.status_code == 201, answer.text
        assert colleague.get(address).content == long
        assert http.get(f"/api/logs/{log_id}/trajectories/theirs").content == long
        token = http.post(f"/api/sessions/{session}/links", json={}).json()["token"]
        shared = colleague.post(f"/api/shared/{token}/sessions").json()["id"]
        for method in ("PUT", "GET", "DELETE"):
            refused = colleague.request(method, f"/api/sessions/{shared}/trajectories/theirs")
            assert (refused.status_code, refused.json()["code"]) == (403, "link.read_only")
        assert colleague.delete(address).status_code == 204
    assert [one["name"] for one in http.get(f"/api/logs/{log_id}").json()["trajectories"]] == ["scan"]


def test_the_robot_of_an_exported_recording_drives_along_an_added_trajectory(service: Service) -> None:
    """Read by rosbags: its poses in the map are those of the trajectory in use, at the times of the scans."""
    http = service.http
    log_id = http.put("/api/logs", params={"name": "exported.log"}, content=carmen(5)).json()["id"]
    once_read(http, log_id)
    put(http, log_id, "mine", tum(5, y=2.5))
    session = service.begin(kind="log", log=log_id, trajectory="mine", playing=False)
    exported = http.get(f"/api/sessions/{session}/run.mcap")
    assert exported.status_code == 200, exported.text
    store = get_typestore(Stores.ROS2_HUMBLE)
    moved: dict[float, tuple[float, float]] = {}
    for schema, _, message in make_reader(BytesIO(exported.content)).iter_messages(topics=["/tf"]):
        assert schema is not None
        found: Any = store.deserialize_cdr(message.data, "tf2_msgs/msg/TFMessage")
        for one in found.transforms:
            at = one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec
            moved[at] = one.transform.translation.x, one.transform.translation.y
    assert moved == {float(k): (float(k), 2.5) for k in range(5)}
