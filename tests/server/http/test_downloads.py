"""Downloads of a log over HTTP: the files are those of the log and the map that the session shows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from mapper.io.export import tum_text
from mapper.io.export.growing_map import MOST_MAPS
from mapper.io.logs import open_log
from mapper.io.maps import occupancy_values
from tests.server.service import Service, until


@pytest.fixture
def session(service: Service) -> Any:
    return service.state.sessions.get(service.begin(kind="log", log="sample-office"))


def test_the_run_with_its_map(service: Service, session: Any, tmp_path) -> None:
    session.model.recording.replay.advance_to(70)  # nobody watches, so nothing plays
    answer = service.http.get(f"/api/sessions/{session.id}/run.mcap")
    assert answer.status_code == 200
    assert answer.headers["content-disposition"] == 'attachment; filename="A_simulated_office_sample.mcap"'
    assert int(answer.headers["content-length"]) == len(answer.content)
    path = tmp_path / "run.mcap"
    path.write_bytes(answer.content)
    again = open_log(path)
    np.testing.assert_array_equal(again.stamps_ns, session.model.recording.log.stamps_ns)
    poses = session.model.recording.log.trajectory(session.model.recording.trajectory).poses
    np.testing.assert_allclose(again.trajectory("tf/map").poses[:, :2], poses[:, :2], atol=1e-9)
    with AnyReader([path]) as reader:
        maps: list[Any] = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == "/map"
        ]
    # As it grew: to what the session shows.
    index, _ = session.model.progress
    assert len(maps) == min(MOST_MAPS, max(1, index))
    shown = session.model.recording.replay.grid
    np.testing.assert_array_equal(maps[-1].data.reshape(shown.geometry.shape), occupancy_values(shown))
    until(lambda: service.state.downloads.slots.taken == 0)
    assert not [one for one in service.state.settings.data_dir.iterdir() if one.is_file()], "no temporary file is left"


def test_the_trajectory(service: Service, session: Any) -> None:
    answer = service.http.get(f"/api/sessions/{session.id}/trajectory.tum")
    assert answer.text == tum_text(session.model.recording.log, session.model.recording.trajectory)
    assert answer.headers["content-disposition"] == 'attachment; filename="A_simulated_office_sample.tum"'


def test_a_simulation_has_no_log_to_download(service: Service) -> None:
    world = service.begin(kind="simulation", world="room", seed=5)
    for name in ("run.mcap", "trajectory.tum"):
        answer = service.http.get(f"/api/sessions/{world}/{name}")
        assert (answer.status_code, answer.json()["code"]) == (409, "session.no_log")
    assert service.http.get("/api/sessions/none/run.mcap").status_code == 404


def test_a_client_that_disconnects_during_a_download_leaves_no_files(service: Service, session: Any) -> None:
    for _ in range(9):
        with service.http.stream("GET", f"/api/sessions/{session.id}/run.mcap") as answer:
            assert answer.status_code == 200
            next(answer.iter_raw(1000))
    answer = service.http.get(f"/api/sessions/{session.id}/run.mcap")
    assert answer.status_code == 200
    until(lambda: service.state.downloads.slots.taken == 0)
    assert not [one for one in service.state.settings.data_dir.iterdir() if one.is_file()]
