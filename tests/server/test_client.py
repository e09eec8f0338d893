"""The client for programs against a running service: its results equal the mapper's for the same file."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ReadError
from mapper.diagnosis import examine
from mapper.io.logs import open_log
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log
from server.client import Client, ClientError, Log
from tests.server.service import Service, running, settings_for, until

TOKEN = "a-token-of-this-test-0123456789"


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated run with right poses, of which the robot did not know that its laser is turned."""
    log = sample_log(40)
    lines = [
        f"angle_min,{log.angle_min}",
        f"angle_increment,{log.angle_increment}",
        f"range_max,{log.range_max}",
        "mount_yaw,1.5707963",
        "stamp,x,y,theta,ranges",
    ]
    for stamp, pose, ranges in zip(log.stamps_ns * 1e-9, log.trajectory("true").poses, log.ranges, strict=True):
        lines.append(",".join(map(str, [stamp, *pose.tolist(), *ranges.tolist()])))
    path = tmp_path_factory.mktemp("run") / "turned.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def client(service: Service, tmp_path: Path) -> Iterator[Client]:
    with Client(f"127.0.0.1:{service.port}", visitors=tmp_path / "visitors.json", pause_s=0.01) as client:
        yield client


def sent(client: Client, path: Path) -> Log:
    return client.wait(client.upload(path))


def test_a_log_is_sent_and_read(client: Client, path: Path) -> None:
    sending: list[float] = []
    reading: list[float] = []
    log = client.wait(client.upload(path, sending.append), reading.append)
    read = open_log(path)
    assert sending[-1] == 1.0
    assert all(0.0 <= share <= 1.0 for share in reading)
    assert (log.name, log.state, log.scans, log.beams) == ("turned.csv", "ready", read.n_scans, read.n_beams)
    assert log.trajectories == tuple(read.trajectories)
    assert log.id in {one.id for one in client.logs()}
    assert client.log(log.id) == log
    client.delete(log)
    with pytest.raises(ClientError, match="no such log"):
        client.log(log.id)


def test_the_map_is_the_mappers_own_cell_by_cell(client: Client, path: Path) -> None:
    read, config = open_log(path), MappingConfig(hit_and_passed="only_hits")
    expected = grid_for(read, config)
    integrate_log(expected, read, config)
    log = sent(client, path)
    found = client.map(log)
    assert found.geometry.shape == expected.geometry.shape
    assert found.geometry.origin == pytest.approx(expected.geometry.origin)
    assert np.array_equal(found.classify(), expected.classify())
    assert client.sessions() == [], "the session for it has ended"


def test_a_session_seeks_to_a_scan_and_its_link_shows_it(client: Client, service: Service, path: Path) -> None:
    session = client.open(sent(client, path))
    assert (session.kind, session.playing, session.index, session.count) == ("log", False, 0, 40)
    session = client.seek(session, 10)
    assert session.index == 10
    part = client.map(session)
    link = client.link(session)
    assert client.seek(session).index == 40
    assert (client.map(session).classify() != -1).sum() > (part.classify() != -1).sum()
    assert client.sessions() == [client.session(session.id)]
    assert client.address(session) == f"http://127.0.0.1:{service.port}/logs.html?session={session.id}"
    token = link.removeprefix(f"http://127.0.0.1:{service.port}/shared/")
    shared = service.http.post(f"/api/shared/{token}/sessions").json()
    assert shared["title"] == "turned.csv"
    # The session is there before its map is.
    until(lambda: service.http.get(f"/api/sessions/{shared['id']}").json()["index"] == 10)
    picture = np.asarray(Image.open(BytesIO(client.picture(session))).convert("L"))
    assert picture.shape == client.map(session).geometry.shape
    assert picture.min() < 60
    assert picture.max() > 200
    client.end(session)
    assert client.sessions() == []


def test_the_doctors_findings_are_those_of_the_library(client: Client, path: Path) -> None:
    expected = examine(open_log(path))
    assert "mount.turned" in {finding.check for finding in expected}
    log = sent(client, path)
    assert client.doctor(log) == expected
    session = client.open(log)
    assert client.doctor(session) == expected
    assert [one.id for one in client.sessions()] == [session.id]


def test_refusals_are_the_services_sentences(client: Client, service: Service, path: Path, tmp_path: Path) -> None:
    picture = tmp_path / "holiday.jpg"
    picture.write_bytes(b"\xff\xd8\xff" + bytes(1000))
    with pytest.raises(ClientError, match="JPEG"):
        sent(client, picture)
    with pytest.raises(ReadError, match="No such file"):
        client.upload(tmp_path / "gone")
    log = sent(client, path)
    with pytest.raises(ClientError, match="no trajectory 'slam'"):
        client.open(log, trajectory="slam")
    session = client.open(log)
    with pytest.raises(ClientError, match="has 40 scans"):
        client.seek(session, 41)
    client.end(session)
    for call in (client.map, client.doctor, client.link, client.seek, client.end):
        with pytest.raises(ClientError):
            call(session)
    with Client(f"127.0.0.1:{service.port}") as stranger:
        assert log.id not in {one.id for one in stranger.logs()}
        with pytest.raises(ClientError):
            stranger.map(log)


def test_a_service_that_is_not_there(path: Path) -> None:
    for url in ("http://127.0.0.1:9", "nonsense://"):
        with pytest.raises(ClientError, match="cannot be reached"), Client(url, pause_s=0.001) as client:
            client.logs()


def test_a_visitor_whose_id_cannot_be_kept_is_a_new_one(service: Service) -> None:
    nowhere = Path("/dev/null/none/visitors.json")
    with Client(f"127.0.0.1:{service.port}", visitors=nowhere) as client:
        assert client.logs()


def test_a_service_of_this_machine_is_not_asked_through_a_proxy(
    service: Service, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("http_proxy", "https_proxy", "all_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")  # nothing listens there
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.delenv("NO_PROXY", raising=False)
    for host in ("127.0.0.1", "localhost"):
        with Client(f"{host}:{service.port}", pause_s=0.01) as client:
            session = client.seek(client.open(sent(client, path)))  # requests, and the stream
            assert session.index == session.count
    with pytest.raises(ClientError, match="cannot be reached"), Client("192.0.2.1", pause_s=0.001) as client:
        client.logs()


def test_a_token_is_required_and_accepted_as_argument_or_in_the_url(path: Path, tmp_path: Path) -> None:
    with running(settings_for(tmp_path, token=TOKEN)) as service:
        base = f"http://127.0.0.1:{service.port}"
        with Client(base) as client, pytest.raises(ClientError, match="access token"):
            client.logs()
        for client in (Client(base, TOKEN), Client(f"{base}/?token={TOKEN}")):
            with client:
                session = client.seek(client.open(sent(client, path)))
                assert session.index == session.count
                assert TOKEN not in client.link(session) + client.address(session)
