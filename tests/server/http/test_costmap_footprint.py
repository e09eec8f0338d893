"""The footprint of a session's costmap over HTTP."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from server.library.logs.sample import SAMPLE_ID
from server.parts.wire import command_of
from tests.server.service import Service, running, settings_for

PADDING = 0.01  # Nav2's footprint_padding, metres
SQUARE = [[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3]]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("footprint"))) as service:
        yield service


@pytest.fixture(params=["simulation", "log"])
def session(request: pytest.FixtureRequest, service: Service) -> str:
    if request.param == "log":
        begun = service.begin(kind="log", log=SAMPLE_ID, playing=False)
        service.state.sessions.get(begun).enqueue(command_of({"type": "seek", "index": 20}))
        return begun
    return service.begin(kind="simulation", world="room", seed=3)


def address(session: str) -> str:
    return f"/api/sessions/{session}/costmap/footprint"


def refusal(answer: httpx.Response) -> tuple[int, str]:
    assert set(answer.json()) == {"code", "message", "detail"}
    return answer.status_code, answer.json()["code"]


def put(service: Service, session: str, footprint: Any) -> httpx.Response:
    return service.http.put(address(session), json={"footprint": footprint})


def test_the_footprint_of_a_costmap_is_changed_and_its_costs_with_it(service: Service, session: str) -> None:
    http, costs = service.http, f"/api/sessions/{session}/costmap/costmap.pgm"
    service.state.sessions.get(session).enqueue(command_of({"type": "costmap"}))
    first = http.get(address(session)).json()
    assert len(first["footprint"]) == 6
    before = http.get(costs).content

    answer = put(service, session, SQUARE)
    assert answer.status_code == 200, answer.text
    half = 0.3 + PADDING
    assert answer.json() == {
        "footprint": SQUARE,
        "inscribed_radius": pytest.approx(half),
        "circumscribed_radius": pytest.approx(half * math.sqrt(2.0), abs=1e-4),
    }
    assert http.get(address(session)).json() == answer.json()
    # The cells at the inscribed radius of an obstacle cost 253: there are more of them for a wider robot.
    n_before, n_after = (
        int((np.frombuffer(file, np.uint8) == 253).sum()) for file in (before, http.get(costs).content)
    )
    assert n_after > n_before


def test_what_is_no_footprint_changes_nothing(service: Service, session: str) -> None:
    assert refusal(service.http.get(address(session))) == (409, "costmap.off")
    assert refusal(put(service, session, SQUARE)) == (409, "costmap.off")
    assert refusal(service.http.get(address(session))) == (409, "costmap.off"), "a refused request begins none"
    service.state.sessions.get(session).enqueue(command_of({"type": "costmap"}))
    first = service.http.get(address(session)).json()
    circle = [[math.cos(0.2 * k), math.sin(0.2 * k)] for k in range(30)]
    for footprint, code in (
        ([], "footprint.vertices"),
        (SQUARE[:2], "footprint.vertices"),
        (circle, "footprint.vertices"),
        ([[100.0 * x / 0.3, 100.0 * y / 0.3] for x, y in SQUARE], "footprint.vertices"),
        ([[1.0, 2.0, 3.0]] * 4, "request.invalid"),
        ([["nan", 0.0]] * 4, "request.invalid"),
        (None, "request.invalid"),
    ):
        assert refusal(put(service, session, footprint)) == (422, code), footprint
    assert service.http.get(address(session)).json() == first
    assert refusal(service.http.get(address("none"))) == (404, "session.unknown")


def test_a_footprint_may_cross_itself_as_in_nav2(service: Service, session: str) -> None:
    """Costmap2DROS::setRobotFootprint takes what it gets; the inscribed radius is the distance to the nearest edge."""
    service.state.sessions.get(session).enqueue(command_of({"type": "costmap"}))
    crossed = [SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]]
    answer = put(service, session, crossed)
    assert (answer.status_code, answer.json()["footprint"]) == (200, crossed)
    assert answer.json()["inscribed_radius"] == pytest.approx(0.0, abs=1e-9)  # two of its edges go through the centre
