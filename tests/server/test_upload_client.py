"""``gridbloom upload`` against a running service, over a connection that is cut repeatedly."""

from __future__ import annotations

import json
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.clouds import read_cloud
from mapper.io.logs import open_log
from mapper.volume import OccupancyVolume, Octree, octree_file, write_octree
from mapper.volume.occupancy.parameters import VolumeConfig
from server.cli import main
from server.client import Client, ClientError
from server.upload_client import TRIES, sent
from tests.mapper.io.logs.containers.test_split import split
from tests.server.frayed_line import FrayedLine
from tests.server.library.small_logs import carmen
from tests.server.service import Service

DATA = carmen(10_000)


@pytest.fixture
def line(service: Service) -> Iterator[FrayedLine]:
    line = FrayedLine(service.port, 1 << 40)
    yield line
    line.close()


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "the run.log"
    path.write_bytes(DATA)
    return path


def upload(file: Path, url: str, visitors: Path, progress: Any = None, pause_s: float = 1.0) -> tuple[Any, str]:
    """Run the upload of ``gridbloom upload``."""
    with Client(url, visitors=visitors, pause_s=pause_s) as client:
        log = client.wait(client.upload(file, progress))
        return log.record, client.address(client.open(log, playing=True))


def stored(service: Service, record_id: str) -> bytes:
    record = service.state.library._catalogue.get(record_id)
    assert record is not None
    return (service.state.settings.data_dir / "library" / "blobs" / record.sha256).read_bytes()


def test_a_log_is_sent_read_and_to_be_seen(service: Service, log: Path, tmp_path: Path) -> None:
    visitors = tmp_path / "who" / "visitors.json"
    shares: list[float] = []
    record, link = upload(log, f"127.0.0.1:{service.port}", visitors, progress=shares.append)
    assert (record["name"], record["state"], record["scans"]) == ("the run.log", "ready", 10_000)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    session = parse_qs(urlsplit(link).query)["session"][0]
    # Who has the link sees it, though the log itself is the sender's alone.
    assert service.http.get(f"/api/sessions/{session}").json()["title"] == "the run.log"
    assert service.http.get(f"/api/logs/{record['id']}").status_code == 404
    assert stat.S_IMODE(visitors.stat().st_mode) == 0o600
    again, _ = upload(log, f"http://127.0.0.1:{service.port}/logs.html", visitors)
    assert again["id"] == record["id"], "the same file is stored once"


def test_a_folder_with_a_log_in_several_files_is_one_log_there(service: Service, tmp_path: Path) -> None:
    folder, whole = split(tmp_path, "mcap", 3)
    url, visitors = f"127.0.0.1:{service.port}", tmp_path / "visitors.json"
    record, _ = upload(folder, url, visitors)
    assert (record["name"], record["scans"]) == ("run", open_log(whole).n_scans)
    assert record["notes"] == ["3 files are read as one recording."]
    (folder / "run_0.mcap").touch()
    assert upload(folder, url, visitors)[0]["id"] == record["id"], "the same files are stored once"
    assert upload(whole.parent, url, visitors)[0]["name"] == "whole"
    (folder / "metadata.yaml").unlink()
    assert upload(folder, url, visitors)[0]["scans"] == record["scans"], "parts are joined by their names"


@pytest.mark.parametrize("tenth", range(1, 11))
def test_it_resumes_after_a_broken_connection(
    service: Service, line: FrayedLine, log: Path, tmp_path: Path, tenth: int
) -> None:
    line.most = len(DATA) * tenth // 10 + 2000
    record, _ = upload(log, line.url, tmp_path / "visitors.json", pause_s=0.01)
    assert record["scans"] == 10_000
    assert stored(service, record["id"]) == DATA
    assert line.connections >= 10 // tenth


@pytest.mark.parametrize(
    ("status", "after", "waits"),
    [(408, None, 0.5), (429, "7", 7.0), (503, "7", 7.0), (429, "9999", 120.0), (429, "soon", 0.5)],
)
def test_it_resumes_after_a_refusal_when_the_service_says_so(
    log: Path, monkeypatch: pytest.MonkeyPatch, status: int, after: str | None, waits: float
) -> None:
    """The second request is refused after half of the bytes were stored, the third, which asks for them, again."""
    got, asked, slept = bytearray(), list[str](), list[float]()
    headers = {} if after is None else {"Retry-After": after}

    def refusal() -> httpx.Response:
        return httpx.Response(status, headers=headers, json={"code": "a", "message": "Later."})

    def answer(asking: httpx.Request) -> httpx.Response:
        asked.append(asking.method)
        if len(asked) == 3:
            return refusal()
        if asking.method == "GET":
            return httpx.Response(200, json={"offset": len(got)})
        assert asking.headers["Content-Range"].startswith(f"bytes {len(got)}-")
        body = asking.read()
        got.extend(body[: len(body) // 2] if len(asked) == 2 else body)
        return refusal() if len(asked) == 2 else httpx.Response(202, json={"id": "1"})

    monkeypatch.setattr("server.upload_client.time.sleep", slept.append)
    with httpx.Client(transport=httpx.MockTransport(answer), base_url="http://service") as client:
        assert sent(client, log, "run.log", len(DATA), "0" * 64, None, 0.5) == {"id": "1"}
    assert got == DATA
    assert asked == ["GET", "PUT", "GET", "GET", "PUT"]
    # The second pause without progress is twice as long where the service states none.
    assert slept == [waits, max(waits, 1.0)]


def test_a_service_that_refuses_again_and_again_is_given_up(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.upload_client.time.sleep", lambda _: None)
    refusal = httpx.Response(429, json={"code": "request.too_many", "message": "Too many requests at once."})
    transport = httpx.MockTransport(lambda _: refusal)
    with (
        httpx.Client(transport=transport, base_url="http://service") as client,
        pytest.raises(ClientError, match="Too many requests at once"),
    ):
        sent(client, log, "run.log", len(DATA), "0" * 64, None, 0.5)


@pytest.mark.parametrize("kind", ["cloud", "octree"])
def test_the_link_of_a_cloud_or_an_octree_opens_it_in_3d(service: Service, tmp_path: Path, kind: str) -> None:
    path = tmp_path / "cloud.xyz"
    path.write_text("".join(f"{x} {y} 1\n" for x in range(10) for y in range(10)))
    if kind == "octree":
        volume = OccupancyVolume(VolumeConfig())
        volume.insert_scan(read_cloud(path).points.astype(np.float64), np.zeros(3))
        path = tmp_path / "tree.bt"
        write_octree(octree_file(Octree.of(volume), ".bt", VolumeConfig(), None), path, VolumeConfig())
    _, link = upload(path, f"127.0.0.1:{service.port}", tmp_path / "visitors.json")
    query = parse_qs(urlsplit(link).query)
    assert query["kind"] == ["volume"]
    assert service.http.get(f"/api/sessions/{query['session'][0]}").json()["kind"] == "volume"


@pytest.mark.parametrize("further", range(600, 1400, 200))
def test_a_cut_after_the_last_byte_is_no_failure(
    service: Service, line: FrayedLine, log: Path, tmp_path: Path, further: int
) -> None:
    line.most = len(DATA) + further  # the questions for the record and the session take some 200 bytes each
    record, link = upload(log, line.url, tmp_path / "visitors.json", pause_s=0.01)
    assert (record["state"], record["scans"]) == ("ready", 10_000)
    session = parse_qs(urlsplit(link).query)["session"][0]
    assert service.http.get(f"/api/sessions/{session}").json()["title"] == "the run.log"


def test_the_command_resumes_an_earlier_upload(service: Service, line: FrayedLine, log: Path, tmp_path: Path) -> None:
    line.most = 300_000
    visitors = tmp_path / "visitors.json"
    shares: list[float] = []

    def noted(share: float) -> None:
        """From its second connection on the line carries nothing to speak of."""
        shares.append(share)
        line.most = 100

    with pytest.raises(ClientError):
        upload(log, line.url, visitors, progress=noted, pause_s=0.001)
    assert line.connections >= TRIES
    line.most = 1 << 40
    shares.clear()
    record, _ = upload(log, line.url, visitors, progress=shares.append, pause_s=0.001)
    assert shares[0] > 0.2, "what the server had was not sent again"
    assert stored(service, record["id"]) == DATA


def test_a_file_that_is_no_log_is_refused_with_the_services_message(service: Service, tmp_path: Path) -> None:
    path = tmp_path / "holiday.jpg"
    path.write_bytes(b"\xff\xd8\xff" + bytes(1000))
    with pytest.raises(ClientError, match="JPEG"):
        upload(path, f"127.0.0.1:{service.port}", tmp_path / "visitors.json")


def test_no_file_no_service_and_a_file_of_garbage_for_the_visitors(service: Service, log: Path, tmp_path: Path) -> None:
    visitors = tmp_path / "visitors.json"
    with pytest.raises(ReadError, match="No such file"):
        upload(tmp_path / "gone", f"127.0.0.1:{service.port}", visitors)
    with pytest.raises(ClientError, match="cannot be reached"):
        upload(log, "http://127.0.0.1:9", visitors, pause_s=0.001)
    with pytest.raises(ClientError, match="cannot be reached"):
        upload(log, "nonsense://", visitors, pause_s=0.001)
    for garbage in (b"[", b"[1]", b'{"http://x": 5}', b"\xff"):
        visitors.write_bytes(garbage)
        assert upload(log, f"127.0.0.1:{service.port}", visitors)[0]["state"] == "ready"


def test_the_command(
    service: Service, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GRIDBLOOM_DATA_DIR", str(tmp_path / "data"))
    for arguments, status in (([], 0), (["--json"], 0)):
        monkeypatch.setattr(
            sys, "argv", ["gridbloom", "upload", str(log), f"http://127.0.0.1:{service.port}", *arguments]
        )
        with pytest.raises(SystemExit) as ended:
            main()
        assert (ended.value.code or 0) == status
        out = capsys.readouterr().out
        assert "logs.html?session=" in out
    assert json.loads(out.splitlines()[-1])["scans"] == 10_000
    monkeypatch.setattr(sys, "argv", ["gridbloom", "upload", str(tmp_path / "gone"), "http://127.0.0.1:9"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
