"""A kind of session with the required methods only works in the whole service."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal, get_args

import numpy as np
import pytest

from mapper.grid import GridGeometry
from server.sessions import Kind, Plan, SessionModel
from server.sessions.kind import Resources, SessionRequest
from server.sessions.tick import TickResult
from server.sources import KINDS
from server.stream.grid_layer import GridLayer
from tests.server.service import Service, Watcher, running, settings_for

GEOMETRY = GridGeometry(0.5, rows=4, cols=6)


class Stopwatch(SessionModel):
    """A grid whose cells all hold the seconds that have passed, 100 at most."""

    kind: ClassVar[str] = "stopwatch"

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self.seconds = seconds
        self._grid = GridLayer("map", "Seconds")
        self._show()

    @property
    def layers(self) -> tuple[GridLayer]:
        """The grid."""
        return (self._grid,)

    def _show(self) -> None:
        self._grid.set(GEOMETRY, np.full(GEOMETRY.shape, min(self.seconds, 100.0), np.float32), 0.0, 100.0)

    def advance(self, dt: float, result: TickResult) -> None:
        """Count."""
        self.seconds += dt * self.playback.speed
        self._show()
        result.changed = True


class NewStopwatch(SessionRequest):
    """A session of a stopwatch."""

    kind: Literal["stopwatch"]
    seconds: float = 0.0


async def plan(wanted: NewStopwatch, _: Resources) -> Plan:
    """Begin with so many seconds."""
    return Plan(lambda _host, _making: Stopwatch(wanted.seconds), playing=wanted.playing)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    kinds = {**KINDS, "stopwatch": Kind(NewStopwatch, plan)}
    with running(settings_for(tmp_path_factory.mktemp("data")), kinds) as one:
        yield one


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_has_one_name(name: str) -> None:
    assert get_args(KINDS[name].request.model_fields["kind"].annotation) == (name,)


async def test_its_layer_its_clock_and_its_errors_reach_a_page(service: Service) -> None:
    session_id = service.begin(kind="stopwatch", seconds=50.0, playing=False)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.complete)
        hello = watcher.newest["hello"]
        assert (hello["kind"], hello["title"]) == ("stopwatch", "Stopwatch")
        assert watcher.log_odds() == pytest.approx(np.full((4, 6), 50.0), abs=100.0 / 254)
        await watcher.send("speed", value=8.0)
        await watcher.send("play")
        await watcher.until(lambda: float(watcher.log_odds()[0, 0]) > 52.0)
        await watcher.send("pause")
        await watcher.until(lambda: not watcher.newest["frame"]["playing"])
        for command in ({"type": "seek", "index": 3}, {"type": "inspect", "row": 0, "col": 0, "epoch": 1}):
            await watcher.send(command.pop("type"), **command)  # type: ignore[arg-type]
            assert (await watcher.answer("error"))["code"] == "command.unknown"


@pytest.mark.parametrize(
    ("address", "status", "code"),
    [
        ("map.yaml", 409, "session.no_map"),
        ("map.pgm", 409, "session.no_map"),
        ("map.png", 409, "session.no_map"),
        ("run.mcap", 409, "session.no_log"),
        ("trajectory.tum", 409, "session.no_log"),
        ("doctor", 409, "session.not_a_log"),
        ("compare", 409, "session.not_a_log"),
        ("story", 409, "session.not_a_world"),
    ],
)
def test_parts_that_it_has_not_are_refused(service: Service, address: str, status: int, code: str) -> None:
    session_id = service.begin(kind="stopwatch", playing=False)
    answer = service.http.get(f"/api/sessions/{session_id}/{address}")
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    service.end_sessions()


def test_requests_are_checked_by_the_kinds_own_model(service: Service) -> None:
    for wanted in ({"kind": "stopwatch", "world": "room"}, {"kind": "stopwatch", "seconds": "many"}, {"kind": "clock"}):
        answer = service.http.post("/api/sessions", json=wanted)
        assert (answer.status_code, answer.json()["code"]) == (422, "request.invalid")
    assert service.http.get("/metrics").text.count('gridbloom_sessions{kind="stopwatch"} 0.0') == 1
