"""``/api/sessions/{id}/scan-series``: what is plotted below the timeline of a log."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.server.library.small_logs import carmen
from tests.server.service import Service, once_read, running, settings_for


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("data"))) as service:
        yield service


def opened(service: Service, content: bytes) -> str:
    log_id = str(service.http.put("/api/logs", params={"name": "run.log"}, content=content).json()["id"])
    assert once_read(service.http, log_id)["state"] == "ready"
    return service.begin(kind="log", log=log_id, playing=False)


def got(service: Service, session: str, **query: Any) -> dict[str, Any]:
    answer = service.http.get(f"/api/sessions/{session}/scan-series", params=query)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_the_whole_log_an_interval_of_it_and_no_more_rows_than_asked_for(service: Service) -> None:
    session = opened(service, carmen(100))
    whole = got(service, session)
    assert (whole["axis"], whole["samples"], len(whole["times"])) == ("time", 100, 100)
    columns = {column["label"]: column for column in whole["columns"]}
    assert columns["speed"]["values"][:3] == [None, 1.0, 1.0]  # a metre a second
    assert columns["returns"]["values"] == [100.0] * 100
    assert columns["interval"]["unit"] == "s"
    part = got(service, session, start=10.0, end=20.0)
    assert part["times"] == [float(at) for at in range(9, 22)]  # and one more at either end
    coarse = got(service, session, buckets=5)
    assert (coarse["samples"], len(coarse["times"])) == (100, 10)


def test_gaps_of_the_recording_wherever_the_interval_and_the_rows_end(service: Service) -> None:
    """Of 100 scans a second apart, 30 s are missing after 20 of them, and 10 s after 60."""
    lines = carmen(100).decode().splitlines(keepends=True)
    numbers = [n for n, line in enumerate(lines) if line.startswith("FLASER")]
    cut = {numbers[n] for n in (*range(20, 50), *range(60, 70))}
    content = "".join(line for n, line in enumerate(lines) if n not in cut).encode()
    session = opened(service, content)
    whole = got(service, session)
    assert whole["gaps"] == [[19.0, 50.0], [59.0, 70.0]]
    assert all(end in whole["times"] for gap in whole["gaps"] for end in gap)
    assert got(service, session, start=52.0, end=99.0)["gaps"] == [[59.0, 70.0]]
    assert got(service, session, start=30.0, end=40.0)["gaps"] == [[19.0, 50.0]]  # all of the plot is within it
    assert got(service, session, start=75.0)["gaps"] == []
    assert got(service, session, buckets=1)["gaps"] == [[19.0, 50.0]]  # the longest
    assert got(service, opened(service, carmen(2, start=7)))["gaps"] == []


def test_refusals_in_words(service: Service) -> None:
    live = service.begin(kind="simulation")
    answer = service.http.get(f"/api/sessions/{live}/scan-series")
    assert answer.status_code == 409
    assert "not a live world" in answer.json()["message"]
    session = opened(service, carmen(2, start=7))
    assert service.http.get(f"/api/sessions/{session}/scan-series", params={"buckets": 0}).status_code == 422
