"""Errors of a log's trajectory against an added one: the figures of evo's definitions, computed here by hand."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from server.http.clients import to_its_end
from server.work.fair_lock import FairLock
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, once_read, running, settings_for, until

SCANS = 20


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("data"))) as service:
        yield service


@pytest.fixture(scope="module")
def session(service: Service) -> str:
    """A log that drives along x, with a trajectory that is turned by 90° and 0.1 m aside at every other scan."""
    log_id = str(service.http.put("/api/logs", params={"name": "run.log"}, content=carmen(SCANS, 10)).json()["id"])
    assert once_read(service.http, log_id)["state"] == "ready"
    half = math.sqrt(0.5)
    lines = [f"{10 + i}.0 {-0.1 * (i % 2)} {10 + i} 0 0 0 {half} {half}" for i in range(SCANS)]
    added = service.http.put(f"/api/logs/{log_id}/trajectories/mine", content="\n".join(lines))
    assert added.status_code == 201, added.text
    return service.begin(kind="log", log=log_id, playing=False)


def errors(service: Service, session: str, **query: str) -> dict[str, Any]:
    known = {"reference": "scan", "estimate": "mine"}
    answer = service.http.get(f"/api/sessions/{session}/trajectory-errors", params=known | query)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_absolute_errors_aligned_and_not(service: Service, session: str) -> None:
    raw = errors(service, session, align="none")
    along = np.arange(SCANS) + 10.0
    by_hand = np.hypot(along + 0.1 * (np.arange(SCANS) % 2), along)
    assert raw["pairs"] == SCANS
    assert raw["absolute"]["translation_m"]["rmse"] == pytest.approx(np.sqrt(np.mean(by_hand**2)))
    assert raw["absolute"]["rotation_rad"]["max"] == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(raw["series"]["absolute"]["translation_m"], by_hand, rtol=1e-5)
    assert raw["series"]["absolute"]["times"] == [float(i) for i in range(SCANS)]
    assert raw["paths"]["estimate"][3] == pytest.approx([-0.1, 13.0])
    # Turned back by least squares, what is left is the zigzag of 0.05 m about its middle.
    aligned = errors(service, session)
    assert aligned["absolute"]["translation_m"]["max"] == pytest.approx(0.05, abs=0.01)
    assert aligned["alignment"]["theta"] == pytest.approx(-math.pi / 2, abs=0.02)
    assert aligned["paths"]["reference"][3] == [13.0, 0.0]


def test_relative_errors_do_not_depend_on_the_alignment(service: Service, session: str) -> None:
    first, second = (errors(service, session, align=how, unit="frames")["relative"] for how in ("none", "rigid"))
    assert first["translation_m"]["rmse"] == pytest.approx(second["translation_m"]["rmse"])
    assert first["translation_m"]["mean"] == pytest.approx(0.1)
    assert (first["pairs"], first["unit"]) == (SCANS - 1, "frames")


def test_the_relative_error_is_among_the_series_that_can_be_plotted(service: Service, session: str) -> None:
    address = f"/api/sessions/{session}/contents"
    until(lambda: service.http.get(address).status_code == 200)
    topics = {one["topic"]: one["fields"] for one in service.http.get(f"{address}/fields").json()["topics"]}
    names = ["relative error distance", "relative error angle"]
    assert topics["(errors)"] == names
    found = errors(service, session)["series"]["relative"]
    for name, expected in zip(names, (found["translation_m"], found["rotation_rad"]), strict=True):
        plotted = service.http.get(f"{address}/field", params={"topic": "(errors)", "field": name}).json()
        assert plotted["times"] == found["times"]
        assert plotted["columns"][0]["values"] == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert max(found["translation_m"]) == pytest.approx(0.1, abs=1e-3)


def test_what_cannot_be_compared(service: Service, session: str) -> None:
    address = f"/api/sessions/{session}/trajectory-errors"
    missing = service.http.get(address, params={"reference": "scan", "estimate": "other"})
    assert missing.status_code == 422
    assert "other" in missing.json()["message"]
    far = service.http.get(address, params={"reference": "scan", "estimate": "mine", "delta": 1e5})
    assert (far.status_code, far.json()["code"]) == (422, "evaluation.no_delta")


async def test_a_cancelled_computation_keeps_its_turn_until_its_thread_ends() -> None:
    turns, begun, ending = FairLock(), threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        ending.wait(PATIENCE_S)

    async def request(owner: str) -> None:
        async with turns.of(owner):
            await to_its_end(asyncio.to_thread(work))

    cancelled = asyncio.create_task(request("ann"))
    await asyncio.to_thread(begun.wait, PATIENCE_S)
    begun.clear()
    cancelled.cancel()
    other = asyncio.create_task(request("ben"))
    for _ in range(10):
        await asyncio.sleep(0)
    assert not cancelled.done()
    assert not begun.is_set()
    ending.set()
    await other
    assert cancelled.cancelled()
