"""``notes``: the notes on a log of a running service, by the address of its page, of the log or of a link."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.client import Client
from server.settings import Settings
from tests.server.cli.running import Run
from tests.server.library.small_logs import carmen
from tests.server.service import Service, running, settings_for

TOKEN = "a-token-of-this-test-0123456789"
CORNERS = [[1.0, 1.0], [4.0, 1.0], [4.0, 3.0]]


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with running(settings_for(tmp_path / "service", token=TOKEN)) as service:
        yield service


def test_notes_are_written_by_each_address_of_the_log(
    run: Run, service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRIDBLOOM_DATA_DIR", str(tmp_path / "data"))
    log = tmp_path / "run.log"
    log.write_bytes(carmen(8))
    base = f"http://127.0.0.1:{service.port}"
    uploaded = json.loads(
        run("upload", log, f"{base}/?token={TOKEN}", "--json").out.splitlines()[-1]
    )  # after the lines of the service
    with Client(base, TOKEN, visitors=Settings().data_dir / "visitors.json") as client:
        session = client.open(client.log(uploaded["id"]))
        link = client.link(session)
    address = f"/api/sessions/{session.id}/notes"
    headers = {"Authorization": f"Bearer {TOKEN}"}
    note = {"text": "wet", "outline": CORNERS}
    assert service.http.post(address, json=note, headers=headers).status_code == 201

    out = tmp_path / "notes.geojson"
    pages = (uploaded["link"], f"{base}/logs.html?log={uploaded['id']}")
    for page in (*(f"{page}&token={TOKEN}" for page in pages), link):
        done = run("notes", page, "-o", out)
        assert done.status == 0, done.err
        (feature,) = json.loads(out.read_text())["features"]
        assert (feature["properties"]["text"], feature["properties"]["area_m2"]) == ("wet", 3.0)
        assert feature["geometry"]["coordinates"] == [[*CORNERS, CORNERS[0]]]
        out.unlink()
    table = tmp_path / "notes.csv"
    assert run("notes", link, "-o", table).status == 0
    (row,) = csv.DictReader(table.read_text().splitlines())
    assert (row["text"], row["outline"]) == ("wet", "POLYGON ((1.0 1.0, 4.0 1.0, 4.0 3.0, 1.0 1.0))")

    for page, file, words in (
        (pages[1], out, "token"),
        (f"{base}/lab.html?token={TOKEN}", out, "neither of a log's page nor of a link"),
        (f"{pages[0]}0&token={TOKEN}", out, "session"),
        (link, tmp_path / "notes.txt", ".geojson, .json or .csv"),
        (link, tmp_path / "none" / "notes.csv", "No such file or directory"),
    ):
        refused = run("notes", page, "--out", file)
        assert refused.status == 2
        assert words in refused.err
    assert not out.exists()
