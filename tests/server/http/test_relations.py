"""The poses of a session's log scored against a file of relations, over HTTP."""

from __future__ import annotations

import httpx
import pytest

from tests.server.library.small_logs import LINE, carmen
from tests.server.service import PATIENCE_S, Service, once_read

ODOM = "ODOM {x} 0 0 0 0 0 {x} h {x}\n"


def relations(*rows: tuple[float, float, float]) -> bytes:
    """A line for each (first time, second time, motion along x)."""
    return "".join(f"{a:.6f} {b:.6f} {x} 0 0 0 0 0\n" for a, b, x in rows).encode()


def begun(service: Service, data: bytes) -> str:
    log_id = service.http.put("/api/logs", params={"name": "run.log"}, content=data).json()["id"]
    once_read(service.http, log_id)
    return service.begin(kind="log", log=log_id, playing=False)


def test_poses_are_off_by_what_the_relations_say(service: Service) -> None:
    """The poses of this log are one metre apart; of two relations one says 0.9 m."""
    session = begun(service, carmen(6))
    known = relations((0.0, 1.0, 1.0), (1.0, 3.0, 1.9))
    found = service.http.put(f"/api/sessions/{session}/relations", params={"name": "a.relations"}, content=known)
    assert found.status_code == 200, found.text
    score = found.json()
    assert (score["trajectory"], score["policy"], score["relations"], score["benchmark"]) == ("scan", "time", 2, None)
    assert score["all"] == {
        "count": 2,
        "translation_m": pytest.approx(0.05, abs=1e-6),
        "rotation_deg": pytest.approx(0.0, abs=1e-6),
    }
    assert (score["published"], score["unambiguous"]) == ([], None)
    # A name that tells a log of the benchmark has results of others beside it.
    beside = service.http.put(f"/api/sessions/{session}/relations", params={"name": "intel.relations"}, content=known)
    assert "Cartographer" in {one["program"] for one in beside.json()["published"]}


def test_relations_whose_stamps_are_of_odometry_messages_are_judged_in_record_order(service: Service) -> None:
    lines = [LINE.format(x=float(k)) + ODOM.format(x=k + 0.5) for k in range(6)]
    session = begun(service, "".join(lines).encode())
    known = relations((0.5, 1.5, 1.0), (1.5, 3.5, 2.0))
    score = service.http.put(f"/api/sessions/{session}/relations", content=known).json()
    assert (score["policy"], score["left_out"]) == ("records", 0)
    assert score["unambiguous"]["count"] == 2
    assert score["all"]["translation_m"] == pytest.approx(0.0, abs=1e-6)


def test_what_is_no_file_of_relations_is_said(service: Service) -> None:
    session = begun(service, carmen(6))
    address = f"/api/sessions/{session}/relations"
    for wrong, word in (
        (b"1 2 3\n", "Line 1"),
        (b"", "no relations"),
        (relations((500.0, 600.0, 1.0)), "time"),
        (b"0" * ((4 << 20) + 1), "4 MiB"),
    ):
        refused = service.http.put(address, params={"name": "mine.txt"}, content=wrong)
        assert refused.status_code in (413, 422), refused.text
        assert word in refused.json()["message"]
    token = service.http.post(f"/api/sessions/{session}/links", json={}).json()["token"]
    with httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S) as guest:
        guests = guest.post(f"/api/shared/{token}/sessions").json()["id"]
        assert guest.put(f"/api/sessions/{guests}/relations", content=b"").status_code in (403, 404)
    simulated = service.begin(kind="simulation", playing=False)
    answer = service.http.put(f"/api/sessions/{simulated}/relations", content=b"")
    assert answer.json()["code"] == "session.not_a_log"
