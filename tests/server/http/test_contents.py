"""``/api/sessions/{id}/contents`` and its subresources, on a small recording."""

from __future__ import annotations

import io
import json
import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mapper.grid import OccupancyGrid
from mapper.grid.metrics import map_metrics
from mapper.io.contents.downsampling import min_max
from mapper.mapping.integrate import geometry_for, integrate_log
from server.jobs.process import BoundedJob, JobLimits
from server.library.packs.arrays import write_arrays
from server.sessions.parts import Recording
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded
from tests.server.library.small_logs import carmen
from tests.server.service import Service, once_read, running, settings_for, until

SECONDS = 4


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("data"))) as service:
        yield service


def opened(service: Service, name: str, content: bytes) -> str:
    log_id = str(service.http.put("/api/logs", params={"name": name}, content=content).json()["id"])
    assert once_read(service.http, log_id)["state"] == "ready"
    return service.begin(kind="log", log=log_id, playing=False)


@pytest.fixture(scope="module")
def session(service: Service) -> str:
    """A session on the recording, of which is known what it holds."""
    session = opened(service, "run.mcap", recorded.mcap_bytes(robot(SECONDS)))
    assert service.http.get(f"/api/sessions/{session}/contents").status_code == 202
    until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
    return session


def got(service: Service, session: str, path: str, **query: Any) -> dict[str, Any]:
    answer = service.http.get(f"/api/sessions/{session}/contents{path}", params=query)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_the_topics_are_listed_and_kept_beside_the_pack(service: Service, session: str) -> None:
    held = got(service, session, "")
    assert held["state"] == "ready"
    topics = {topic["name"]: topic for topic in held["topics"]}
    assert topics["/scan"] == {
        "name": "/scan",
        "type": "sensor_msgs/LaserScan",
        "messages": 40,
        "bytes": topics["/scan"]["bytes"],
        "rate_hz": pytest.approx(10.0),
        "first_s": 0.0,
        "last_s": pytest.approx(3.9),
        "mapped": True,
        "cut": False,
    }
    assert topics["/imu"]["mapped"] is None
    assert {one["topic"] for one in held["series"]} == {"/imu", "/odom", "/battery", "/cmd_vel"}
    assert held["frames"] == 3
    library: Path = service.state.settings.data_dir / "library" / "packs"
    assert len(list(library.glob("*.contents.npz"))) == 1


def test_a_series_in_seconds_of_the_log_with_its_extremes(service: Service, session: str) -> None:
    whole = got(service, session, "/series", topic="/imu")
    assert len(whole["times"]) == 20 * SECONDS
    assert whole["times"][:2] == [0.0, 0.05]
    rates = whole["columns"][2]
    assert (rates["label"], rates["unit"], rates["plot"]) == ("z", "rad/s", "angular velocity")
    few = got(service, session, "/series", topic="/imu", buckets=8)
    assert len(few["times"]) == 16
    assert max(few["columns"][2]["values"]) == max(rates["values"])
    assert min(few["columns"][2]["values"]) == min(rates["values"])
    part = got(service, session, "/series", topic="/imu", start=1.0, end=2.0)
    assert (part["times"][0], part["times"][-1]) == (0.95, 2.05)
    refused = service.http.get(f"/api/sessions/{session}/contents/series", params={"topic": "/scan"})
    assert refused.json()["code"] == "contents.no_series"


def test_a_series_is_computed_beside_the_event_loop(
    service: Service, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of millions of samples takes seconds, in which no stream would go on."""
    threads: list[threading.Thread] = []

    def noted(*arguments: Any) -> Any:
        threads.append(threading.current_thread())
        return min_max(*arguments)

    monkeypatch.setattr("server.http.series_answer.min_max", noted)
    got(service, session, "/series", topic="/imu")
    assert [thread.name != "uvicorn" for thread in threads] == [True]
    assert any(thread.name == "uvicorn" for thread in threading.enumerate()), "the event loop's"


def test_the_transforms_at_a_moment(service: Service, session: str) -> None:
    found = got(service, session, "/frames", at=1.03)
    assert (found["fixed"], found["sensor"], found["faults"]) == ("odom", "laser", [])
    assert (found["tf"], found["trees"]) == ("/tf", ["/tf"])
    static, moving = found["edges"]
    assert (static["parent"], static["child"], static["static"], static["age_s"]) == ("base_link", "laser", True, 0.0)
    assert moving["age_s"] == pytest.approx(0.03)
    assert moving["rate_hz"] == pytest.approx(10.0)
    assert static["offset"] == [0.2, 0.0, 0.0]
    assert moving["offset"] == pytest.approx([1.03, 0.0, 0.0]), "0.05 m for each step of 0.05 s"
    assert moving["angles"] == pytest.approx([0.0, 0.0, 0.0])
    assert (moving["topic"], moving["publishers"], found["elsewhere"]) == ("/tf", [], [])
    assert got(service, session, "/frames", fixed="base_link")["fixed"] == "base_link"
    refused = service.http.get(f"/api/sessions/{session}/contents/frames", params={"fixed": "moon"})
    assert refused.json()["code"] == "contents.no_frame"
    refused = service.http.get(f"/api/sessions/{session}/contents/frames", params={"tf": "/moon/tf"})
    assert refused.json()["code"] == "contents.no_tree"


def test_the_age_of_a_transform_over_time(service: Service, session: str) -> None:
    found = got(service, session, "/frame_age", tf="/tf", parent="odom", child="base_link")
    (age,) = found["columns"]
    assert (age["label"], age["unit"], found["gaps"]) == ("age", "s", [])
    assert found["times"][:4] == [0.0, 0.1, 0.1, 0.2]
    assert age["values"][:4] == pytest.approx([0.0, 0.1, 0.0, 0.1])
    address = f"/api/sessions/{session}/contents/frame_age"
    for query in (
        {"tf": "/tf_static", "parent": "base_link", "child": "laser"},
        {"tf": "/x", "parent": "a", "child": "b"},
    ):
        assert service.http.get(address, params=query).json()["code"] == "contents.no_edge"


def test_an_inspection_that_is_cancelled_ends_in_its_process_and_begins_anew(
    service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The inspection is held up in its process, which therefore has to be ended: it would never come back."""
    begun = tmp_path / "begun"
    monkeypatch.setattr("server.library.processing.inspections.InspectJob", partial(HeldUpJob, begun))
    session = opened(service, "held.mcap", recorded.mcap_bytes(robot(1)))
    address = f"/api/sessions/{session}/contents"
    # Each request keeps it alive: one that nobody asks for ends after a while, which a busy machine may need to begin.
    until(lambda: service.http.get(address).status_code == 202 and begun.exists())
    process = int(begun.read_text())
    assert service.http.delete(address).status_code == 204
    until(lambda: has_ended(process))
    monkeypatch.undo()
    until(lambda: service.http.get(address).status_code == 200)
    assert service.http.delete(address).status_code == 204, "nothing is under way, and what is known stays"
    assert service.http.get(address).status_code == 200


def has_ended(process: int) -> bool:
    """Return whether there is no such process, or only its exit status."""
    try:
        return "Z" in Path(f"/proc/{process}/stat").read_text().split()[2]
    except (FileNotFoundError, ProcessLookupError):
        return True


@dataclass(frozen=True, slots=True)
class HeldUpJob(BoundedJob[None]):
    """Stand in for ``InspectJob``: write to ``begun`` which process it is, and wait for its end."""

    begun: Path
    source: str
    target: str
    limits: JobLimits

    def compute(self) -> None:
        """Write it, and wait."""
        self.begun.with_suffix(".half").write_text(str(os.getpid()))
        self.begun.with_suffix(".half").rename(self.begun)
        signal.pause()


def _looked_at(service: Service, session: str) -> dict[str, Any]:
    """Return the answer to the question what the recording holds, once it is not that this is being found out."""
    answers: list[Any] = []

    def is_known() -> bool:
        answers.append(service.http.get(f"/api/sessions/{session}/contents"))
        return bool(answers[-1].status_code != 202)

    until(is_known)
    return dict(answers[-1].json())


def test_contents_of_another_version_are_found_out_again(tmp_path: Path) -> None:
    data = recorded.mcap_bytes(robot(1))
    with running(settings_for(tmp_path)) as service:
        session = opened(service, "run.mcap", data)
        assert _looked_at(service, session)["state"] == "ready"
        (kept,) = tmp_path.rglob("*.contents.npz")
        # as a later version of the service has stored it
        with np.load(kept) as arrays:
            about = json.loads(arrays["about"].tobytes())
            others = {name: arrays[name] for name in arrays if name != "about"}
        write_arrays(kept, json.dumps(about | {"version": about["version"] + 1}), others)
        visitor = dict(service.http.cookies)
    with running(settings_for(tmp_path)) as service:
        service.http.cookies.update(visitor)
        (log,) = (log for log in service.http.get("/api/logs").json()["logs"] if log["name"] == "run.mcap")
        session = service.begin(kind="log", log=log["id"], playing=False)
        assert _looked_at(service, session)["state"] == "ready"


def test_a_text_log_and_a_world(service: Service) -> None:
    session = opened(service, "run.log", carmen(5, start=10))
    until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
    topics = got(service, session, "")["topics"]
    assert [(topic["name"], topic["messages"], topic["rate_hz"]) for topic in topics] == [("FLASER", 5, 1.0)]
    assert got(service, session, "/frames")["edges"] == []
    world = service.begin(kind="simulation", playing=False)
    assert service.http.get(f"/api/sessions/{world}/contents").json()["code"] == "session.not_a_log"


def test_what_the_scans_do_to_the_map(service: Service) -> None:
    session = opened(service, "run.log", carmen(8))
    address = f"/api/sessions/{session}/contents"
    until(lambda: service.http.get(address).status_code == 200)

    def ready(topic: str, field: str) -> dict[str, Any]:
        query = {"topic": topic, "field": field}
        until(lambda: service.http.get(f"{address}/field", params=query).status_code != 202)
        return got(service, session, "/field", **query)

    topics = {one["topic"]: one["fields"] for one in got(service, session, "/fields")["topics"] if one["computed"]}
    assert topics == {
        "(scans)": ["speed", "turn rate", "pose step", "returns", "interval"],
        "(map)": ["entropy", "cells changed", "contradicted"],
    }
    assert ready("(scans)", "speed")["columns"][0]["values"] == [None] + [1.0] * 7
    entropy = ready("(map)", "entropy")
    assert entropy["times"] == [float(n) for n in range(8)]
    recording = service.state.sessions.get(session).model.find(Recording)
    assert recording is not None
    config = recording.replay.config
    grid = OccupancyGrid(geometry_for(recording.log, config))
    integrate_log(grid, recording.log, config)
    metrics = map_metrics(grid)
    assert entropy["columns"][0]["values"][-1] == pytest.approx(metrics.entropy_bits, rel=1e-6)
    assert sum(ready("(map)", "cells changed")["columns"][0]["values"]) >= metrics.free + metrics.occupied
    refused = service.http.get(f"{address}/field", params={"topic": "(map)", "field": "weight"})
    assert refused.json()["code"] == "contents.no_field"


def test_any_field_over_time(service: Service, session: str) -> None:
    def ready(path: str, **query: Any) -> dict[str, Any]:
        address = f"/api/sessions/{session}/contents{path}"
        until(lambda: service.http.get(address, params=query).status_code != 202)
        return got(service, session, path, **query)

    topics = {topic["topic"]: topic for topic in ready("/fields")["topics"]}
    assert {"angular_velocity.z", "orientation.yaw"} <= set(topics["/imu"]["fields"])
    turning = ready("/field", topic="/imu", field="angular_velocity.z")
    assert turning["times"] == pytest.approx([n / 20 for n in range(20 * SECONDS)])
    assert turning["columns"][0]["values"] == pytest.approx([0.1 * np.sin(n) for n in range(20 * SECONDS)])
    assert turning["columns"][0]["unit"] == "rad/s"
    turned = ready("/field", topic="/imu", field="orientation.yaw", made="derivative", start=1.0, end=2.0)
    assert turned["columns"][0]["values"] == pytest.approx([0.2] * len(turned["times"]), abs=1e-6)
    assert turned["columns"][0]["unit"] == "rad/s"
    even = ready("/field", topic="/imu", field="orientation.x", buckets=5, evenly=True)
    assert even["times"] == pytest.approx([0.4 * n for n in range(10)])
    # What has no stamp of its own is as much later as the recording of the scans is.
    assert ready("/field", topic="/cmd_vel", field="linear.x", made="average")["times"] == [0.0, 1.0, 2.0, 3.0]
    address = f"/api/sessions/{session}/contents/field"
    for query, code in (({"topic": "/imu", "field": "x"}, "no_field"), ({"topic": "/none", "field": "x"}, "no_topic")):
        assert service.http.get(address, params=query).json()["code"] == f"contents.{code}"


def test_the_lines_that_nodes_logged(service: Service) -> None:
    late = recorded.SECOND // 5  # what states no time is recorded as much later as the scans
    said = [recorded.scan(T0 + n * recorded.SECOND, [1.0, 2.0]) for n in range(3)]
    said += [recorded.log_line(T0 + recorded.SECOND, 30, "Wheel slips"), recorded.log_line(T0, 20, "Ready", "driver")]
    unstamped = recorded.log_line(0, 40, "Bumper pressed")
    said.append(recorded.Said(unstamped.topic, unstamped.kind, T0 + 2 * recorded.SECOND, unstamped.fields))
    for one in said:
        one.stamp_ns += late
    session = opened(service, "lines.mcap", recorded.mcap_bytes(said))
    until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
    found = got(service, session, "/lines")
    assert found == {
        "lines": [
            {"seconds": 0.0, "level": 20, "topic": "/rosout", "name": "driver", "text": "Ready"},
            {"seconds": 1.0, "level": 30, "topic": "/rosout", "name": "base", "text": "Wheel slips"},
            {"seconds": 2.0, "level": 40, "topic": "/rosout", "name": "base", "text": "Bumper pressed"},
        ],
        "left_out": 0,
    }


def test_a_picture_of_the_moment(service: Service) -> None:
    said = [one for n in range(5) for one in camera_and_scan(T0 + n * recorded.SECOND, 50 * n)]
    session = opened(service, "camera.mcap", recorded.mcap_bytes(said))
    address = f"/api/sessions/{session}/contents/picture"
    early = service.http.get(address, params={"topic": "/camera", "at": 0.0})
    assert (early.status_code, early.json()["code"]) == (409, "contents.not_yet")
    until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
    assert got(service, session, "")["pictures"] == ["/camera"]
    answer = service.http.get(address, params={"topic": "/camera", "at": 2.5})
    assert (answer.status_code, answer.headers["content-type"]) == (200, "image/jpeg")
    # The camera's message was recorded 0.1 s after the scan, whose stamp is the moment 2 s.
    assert float(answer.headers["x-picture-seconds"]) == pytest.approx(2.1)
    np.testing.assert_allclose(np.asarray(Image.open(io.BytesIO(answer.content))), 100, atol=2)
    refused = service.http.get(address, params={"topic": "/scan", "at": 0.0})
    assert refused.json()["code"] == "contents.no_picture"


def camera_and_scan(stamp_ns: int, grey: int) -> list[recorded.Said]:
    pixels = np.full((6, 8), grey, dtype=np.uint8)
    return [recorded.scan(stamp_ns, [1.0, 2.0]), image(pixels, "mono8", stamp_ns + recorded.SECOND // 10)]


def test_a_place_is_seen_along_the_trajectory_in_use(service: Service) -> None:
    info = recorded.camera(T0, (32, 24), 16.0, "/camera_info")
    info.fields["d"][0] = -0.18
    camera = [
        image(np.full((24, 32), 200, dtype=np.uint8), "mono8", T0 + recorded.SECOND),
        info,
        recorded.transform(T0, "base_link", "optical", yaw=-np.pi / 2, roll=-np.pi / 2, z=1.0),
    ]
    session = opened(service, "camera.mcap", recorded.mcap_bytes([*robot(SECONDS), *camera]))
    until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
    # After 2 s the robot is 2 m along x; the place is 3 m ahead of it and 1 m to the left, r² = 2/9 from the axis.
    bent = 1.0 - 0.18 * 2.0 / 9.0
    assert got(service, session, "/camera", topic="/camera", at=2.0, x=5.0, y=1.0) == {
        "where": "inside",
        "u": pytest.approx(0.5 - 0.5 / 3.0 * bent),
        "v": pytest.approx(0.5 + 2.0 / 3.0 / 3.0 * bent),
        "why": "",
    }
    assert got(service, session, "/camera", topic="/rear/image", x=5.0, y=1.0) == {
        "where": None,
        "u": 0.0,
        "v": 0.0,
        "why": "the log has no CameraInfo on /rear/camera_info",
    }
