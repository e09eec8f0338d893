"""Healing over HTTP: the session follows the job, shows the graph of its poses, and follows changes by hand."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import httpx
import pytest

from server.library.processing.slam import SlamJob, SlamOutcome
from server.sessions.parts import Recording
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with pytest.MonkeyPatch.context() as patch:
        worker_at = __import__("server.jobs.workers", fromlist=["worker_at"]).worker_at
        made: list[Any] = []

        def first_a_real_one(*given: Any) -> Any:
            made.append(stand_ins.ThreadWorker() if made else worker_at(*given))
            return made[-1]

        patch.setattr("server.library.library.worker_at", first_a_real_one)
        patch.setattr("server.library.processing.slam.SlamJob.compute", stand_ins.quick)
        with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
            yield service


@pytest.fixture(scope="module")
def log_id(service: Service) -> str:
    found = str(service.http.put("/api/logs", params={"name": "run.log"}, content=carmen(6)).json()["id"])
    once_read(service.http, found)
    return found


def ended(http: httpx.Client, log_id: str) -> dict[str, Any]:
    state = "state"
    return dict(
        until(lambda: (one := http.get(f"/api/logs/{log_id}/slam").json())[state] not in ("queued", "running") and one)
    )


def shown(service: Service, session: str) -> tuple[str, int]:
    """The trajectory of a session's map, and the number of scans in it."""
    recording = service.state.sessions.get(session).model.find(Recording)
    assert recording is not None
    return recording.trajectory, recording.view().index


def ys(http: httpx.Client, session: str) -> list[float]:
    lines = http.get(f"/api/sessions/{session}/trajectory.tum").text.splitlines()
    return [float(line.split()[2]) for line in lines]


def test_a_session_follows_and_its_graph_is_changed(service: Service, log_id: str) -> None:
    http = service.http
    assert http.get(f"/api/logs/{log_id}/slam").json()["state"] == "none"
    session = service.begin(kind="log", log=log_id, playing=False)
    assert http.get(f"/api/sessions/{session}/graph").json() == {"graph": None}
    answer = http.post(f"/api/sessions/{session}/heal")
    assert answer.status_code == 202, answer.text
    assert ended(http, log_id)["result"]["sharpness"] == [0.25, 0.75]
    until(lambda: shown(service, session) == ("SLAM", 6))
    until(lambda: ys(http, session) == [stand_ins.Y] * 6)

    until(lambda: http.get(f"/api/sessions/{session}/contents").status_code == 200)
    fields = http.get(f"/api/sessions/{session}/contents/fields").json()["topics"]
    assert "loop residual distance" in next(one for one in fields if one["topic"] == "(slam)")["fields"]
    query = {"topic": "(slam)", "field": "loop residual distance"}
    residual = http.get(f"/api/sessions/{session}/contents/field", params=query).json()
    assert residual["columns"][0]["values"] == [None] * 5 + [0.5], "the loop is half a metre too short"
    model = service.state.sessions.get(session).model
    assert [one.name for one in model.layers] == ["map"], "a plot does not show the graph"

    graph = http.get(f"/api/sessions/{session}/graph").json()["graph"]
    (loop,) = graph["loops"]
    assert (graph["nodes"], graph["odometry"], loop["scans"]) == (6, 5, [0, 5])
    until(lambda: [one.name for one in model.layers] == ["map", "graph"])  # the session's next tick shows the graph
    edge = http.get(f"/api/sessions/{session}/graph/edges/{loop['edge']}").json()
    assert (edge["kind"], len(edge["points"]["i"]), len(edge["points"]["aligned"])) == ("loop", 3, 3)
    near = http.get(f"/api/sessions/{session}/graph/candidates", params={"x": 1.0, "y": stand_ins.Y}).json()
    assert near["candidates"][0]["reason"].startswith("only 30 %")
    assert http.get(f"/api/sessions/{session}/graph/candidates/1").json()["scans"] == [1, 4]

    def xs() -> list[float]:
        lines = http.get(f"/api/sessions/{session}/trajectory.tum").text.splitlines()
        return [float(line.split()[1]) for line in lines]

    before = xs()
    changed = http.post(f"/api/sessions/{session}/graph", json={"remove": loop["edge"]}).json()["graph"]
    assert (changed["loops"], changed["changed"]) == ([], True)
    until(lambda: xs() != before)
    after = xs()
    assert after[-1] > before[-1] + 0.3, "nothing holds the ends together"
    assert http.get(f"/api/sessions/{session}/graph/edges/99").json()["code"] == "graph.edge"
    assert http.post(f"/api/sessions/{session}/graph", json={"remove": 0}).json()["code"] == "graph.edge"

    kept = http.post(f"/api/sessions/{session}/graph/keep")
    assert kept.json()["description"].endswith("its graph was changed by hand")
    other = service.begin(kind="log", log=log_id, trajectory="SLAM", playing=False)
    lines = http.get(f"/api/sessions/{other}/trajectory.tum").text.splitlines()
    assert [float(line.split()[1]) for line in lines] == pytest.approx(after, abs=1e-5)
    assert http.get(f"/api/sessions/{other}/graph").json()["graph"]["loops"] == []

    token = http.post(f"/api/sessions/{other}/links", json={}).json()["token"]
    with httpx.Client(base_url=http.base_url, timeout=PATIENCE_S) as guest:
        guests = guest.post(f"/api/shared/{token}/sessions").json()["id"]
        assert guest.get(f"/api/sessions/{guests}/graph").json()["graph"]["nodes"] == 6
        for refused in (
            guest.post(f"/api/sessions/{guests}/graph/keep"),
            guest.post(f"/api/sessions/{guests}/heal"),
        ):
            assert refused.status_code in (403, 404), refused.text


def test_a_job_has_the_parameters_that_it_is_begun_with(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[dict[str, Any]] = []

    def noted(job: Any) -> Any:
        given.append(job.parameters)
        return stand_ins.quick(job)

    monkeypatch.setattr("server.library.processing.slam.SlamJob.compute", noted)
    http = service.http
    table = {row["name"]: row for row in http.get("/api/slam/parameters").json()["table"]}
    assert table["loop_window"]["unit"] == "m"
    log_id = http.put("/api/logs", params={"name": "tuned.log"}, content=carmen(6)).json()["id"]
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    for wrong in ({"loop_window": 99}, {"loop_score": "much"}, {"windows": 1}):
        refused = http.post(f"/api/sessions/{session}/heal", json={"parameters": wrong})
        assert refused.status_code == 422, refused.text
        assert next(iter(wrong)) in refused.json()["message"]
    first = table["neighbours"]["initial"]
    answer = http.post(f"/api/sessions/{session}/heal", json={"parameters": {"loop_window": 6, "neighbours": first}})
    assert answer.json()["parameters"] == {"loop_window": 6.0}
    assert ended(http, log_id)["state"] == "done"
    assert given == [{"loop_window": 6.0}]
    assert http.post(f"/api/logs/{log_id}/slam", json={"parameters": {"robust": "none"}}).status_code == 202
    assert ended(http, log_id)["parameters"] == {"robust": "none"}


def test_after_a_cancelled_job_the_map_is_the_one_from_before(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    http = service.http
    monkeypatch.setattr("server.library.processing.slam.SlamJob.compute", stand_ins.endless)
    log_id = http.put("/api/logs", params={"name": "other.log"}, content=carmen(7)).json()["id"]
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    http.post(f"/api/sessions/{session}/heal")
    until(lambda: shown(service, session) == ("SLAM", 3))
    assert ys(http, session)[0] == stand_ins.Y
    assert http.delete(f"/api/logs/{log_id}/slam").json()["state"] == "cancelled"
    until(lambda: shown(service, session) == ("scan", 7))
    recording = service.state.sessions.get(session).model.find(Recording)
    assert recording is not None
    until(lambda: [*recording.log.trajectories] == ["scan"])
    assert http.get(f"/api/sessions/{session}/graph").json() == {"graph": None}


def test_a_session_that_is_begun_during_the_job_follows_it(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    may_end = threading.Event()

    def slow(job: SlamJob) -> SlamOutcome:
        may_end.wait(PATIENCE_S)
        return stand_ins.quick(job)

    monkeypatch.setattr("server.library.processing.slam.SlamJob.compute", slow)
    http = service.http
    log = http.put("/api/logs", params={"name": "again.log"}, content=carmen(6) + b"# again\n").json()["id"]
    once_read(http, log)
    first = service.begin(kind="log", log=log, playing=False)
    assert http.post(f"/api/sessions/{first}/heal").status_code == 202
    assert http.delete(f"/api/sessions/{first}").status_code == 204
    others = [service.begin(kind="log", log=log, playing=False), service.begin(kind="log", log=log, whole=True)]
    assert shown(service, others[0])[0] != "SLAM"
    until(lambda: shown(service, others[1]) == ("scan", 6))
    may_end.set()
    until(lambda: all(shown(service, other) == ("SLAM", 6) for other in others))


def test_who_has_the_address_of_a_session_can_heal_its_log(service: Service) -> None:
    """As the person does who opens the address that `gridbloom upload` prints."""
    log_id = service.http.put("/api/logs", params={"name": "third.log"}, content=carmen(5)).json()["id"]
    once_read(service.http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    address = f"/api/sessions/{session}/heal"
    with httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S) as other:
        assert other.get(f"/api/logs/{log_id}/slam").status_code == 404
        assert other.get(address).json()["state"] == "none"
        assert other.post(address).status_code == 202
        until(lambda: other.get(address).json()["state"] == "done")
        until(lambda: shown(service, session) == ("SLAM", 5))
        assert other.delete(address).json()["state"] == "done"


@pytest.mark.parametrize("ask", ["heal", "graph"])
def test_a_simulation_has_nothing_to_heal(service: Service, ask: str) -> None:
    session = service.begin()
    method: Callable[..., httpx.Response] = service.http.post if ask == "heal" else service.http.get
    assert method(f"/api/sessions/{session}/{ask}").json()["code"] == "session.not_a_log"
