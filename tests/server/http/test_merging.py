"""Two logs of one place merged over HTTP: both get poses in one frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import httpx
import pytest

from mapper.core.errors import ConfigError
from server.library.library import Library
from server.library.packs.log import log_in
from server.library.processing.merging import MergeJob, MergeOutcome
from server.sessions.view import LogView
from server.sources.log_recording import LogRecording
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until


def apart(job: MergeJob) -> MergeOutcome:
    raise ConfigError("merge.apart", "The two logs do not show the same place.")


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with pytest.MonkeyPatch.context() as patch:
        worker_at: Callable[..., Any] = __import__("server.jobs.workers", fromlist=["worker_at"]).worker_at
        made: list[Any] = []

        def first_a_real_one(*given: Any) -> Any:
            made.append(stand_ins.ThreadWorker() if made else worker_at(*given))
            return made[-1]

        patch.setattr("server.library.library.worker_at", first_a_real_one)
        patch.setattr("server.library.processing.merging.MergeJob.compute", stand_ins.quick_merge)
        with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
            yield service


@pytest.fixture(scope="module")
def logs(service: Service) -> tuple[str, str]:
    found = []
    for name, start in (("first.log", 0), ("second.log", stand_ins.SECOND_START)):
        log_id = service.http.put("/api/logs", params={"name": name}, content=carmen(6, start)).json()["id"]
        once_read(service.http, log_id)
        found.append(str(log_id))
    return found[0], found[1]


def ended(http: httpx.Client, session: str) -> dict[str, Any]:
    address = f"/api/sessions/{session}/merge"
    return dict(until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one))


def ys(http: httpx.Client, session: str) -> list[float]:
    lines = http.get(f"/api/sessions/{session}/trajectory.tum").text.splitlines()
    return [float(line.split()[2]) for line in lines]


def test_both_logs_have_the_merged_poses_and_their_maps_are_compared(service: Service, logs: tuple[str, str]) -> None:
    http = service.http
    session = service.begin(kind="log", log=logs[0], playing=False)
    address = f"/api/sessions/{session}/merge"
    assert http.get(address).json()["state"] == "none"
    answer = http.post(address, json={"log": logs[1]})
    assert answer.status_code == 202, answer.text
    found = ended(http, session)
    assert (found["state"], found["other"]) == ("done", logs[1])
    result = found["result"]
    assert (result["trajectory"], result["loops"], result["tried"], result["note"]) == ("merged", 7, 9, "")
    # The scans of both are a log of their own.
    assert once_read(http, result["log"])["name"] == result["name"] == "first and second, merged.mcap"
    assert http.post("/api/sessions", json={"kind": "log", "log": result["log"]}).json()["count"] == 12
    # They have the graph of both.
    both = service.begin(kind="log", log=result["log"], trajectory="SLAM", playing=False)
    assert len(http.get(f"/api/sessions/{both}/graph").json()["graph"]["loops"]) == 1
    for log_id in logs:
        other = service.begin(kind="log", log=log_id, trajectory="merged", playing=False)
        assert ys(http, other) == [2.0] * 6
    beside = {"log": logs[1], "trajectory": "merged"}
    assert http.put(f"/api/sessions/{session}/compare", json=beside).status_code == 200


def test_a_merge_has_the_mount_of_the_map(
    service: Service, logs: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    mounts: list[tuple[float, float, float]] = []

    def look(job: MergeJob) -> MergeOutcome:
        mounts.extend(log_in(pack).mount for pack in (job.first, job.second))
        return stand_ins.quick_merge(job)

    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", look)
    seen = LogRecording.view

    def with_mount(recording: LogRecording) -> LogView:
        view = seen(recording)
        return replace(view, values={**(view.values or {}), "mount_x": 0.25, "mount_yaw": 0.5})

    monkeypatch.setattr(LogRecording, "view", with_mount)
    session = service.begin(kind="log", log=logs[0], playing=False)
    address = f"/api/sessions/{session}/merge"
    for more, second in (({}, (0.25, 0.0, 0.5)), ({"mapping": {"mount_x": -0.5}}, (-0.5, 0.0, 0.0))):
        mounts.clear()
        assert service.http.post(address, json={"log": logs[1], **more}).status_code == 202
        assert ended(service.http, session)["state"] == "done"
        assert mounts == [(0.25, 0.0, 0.5), second]
    wrong = service.http.post(address, json={"log": logs[1], "mapping": {"mount_x": "far"}})
    assert (wrong.status_code, wrong.json()["code"]) == (422, "parameter.mount_x")


def test_what_cannot_be_merged_is_said(
    service: Service, logs: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    http = service.http
    session = service.begin(kind="log", log=logs[0], playing=False)
    address = f"/api/sessions/{session}/merge"
    assert http.post(address, json={"log": logs[0]}).json()["code"] == "merge.same"
    assert http.post(address, json={"log": "nothing"}).status_code == 404
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", apart)
    http.post(address, json={"log": logs[1]})
    assert ended(http, session)["error"] == {
        "code": "merge.apart", "message": "The two logs do not show the same place."
    }  # fmt: skip
    token = http.post(f"/api/sessions/{session}/links", json={}).json()["token"]
    with httpx.Client(base_url=http.base_url, timeout=PATIENCE_S) as guest:
        guests = guest.post(f"/api/shared/{token}/sessions").json()["id"]
        assert guest.post(f"/api/sessions/{guests}/merge", json={"log": logs[1]}).status_code in (403, 404)


def test_a_merge_is_cancelled(service: Service, logs: tuple[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", stand_ins.endless_merge)
    session = service.begin(kind="log", log=logs[1], playing=False)
    address = f"/api/sessions/{session}/merge"
    service.http.post(address, json={"log": logs[0]})
    until(lambda: service.http.get(address).json()["stage"] == "loops")
    assert service.http.post(address, json={"log": logs[0]}).json()["code"] == "merge.too_many"
    assert service.http.delete(address).json()["state"] == "cancelled"


def test_scans_are_cut_as_in_the_session(
    service: Service, logs: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    cuts: list[float] = []
    load = Library.load

    async def seen(self: Library, owner: str, log_id: str, topic: str | None = None, cut: Any = None) -> Any:
        cuts.append(cut.values["min_height"])
        return await load(self, owner, log_id, topic, cut)

    http, low = service.http, {"min_height": 0.3}
    session = service.begin(kind="log", log=logs[0], cut=low, playing=False)
    monkeypatch.setattr(Library, "load", seen)
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", apart)
    address = f"/api/sessions/{session}/merge"
    assert http.post(address, json={"log": logs[1], "cut": {"height": 1.0}}).status_code in (400, 422)
    http.post(address, json={"log": logs[1]})
    assert ended(http, session)["state"] == "failed"
    assert cuts[:2] == [0.3, 0.3]
