"""Notes on a log: written, changed, deleted, seen through a link, and gone with the log."""

from __future__ import annotations

import asyncio
import csv
import io
import itertools
import re
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import httpx
import pytest

from server.library.annotations.note_files import MapFrame, notes_as_csv
from server.library.annotations.notes import Note, Pin
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, Watcher, once_read, running, settings_for

TIME = {"at_s": 2.0, "scan": 3}
PLACE = {"x": 1.5, "y": -0.5}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("notes")


@pytest.fixture(scope="module")
def service(folder: Path) -> Iterator[Service]:
    with running(settings_for(folder)) as service:
        yield service


NUMBERS = count(10)


def opened(service: Service) -> tuple[str, str]:
    """A log of its own, and a session on it."""
    content = carmen(8, next(NUMBERS))
    log_id = str(service.http.put("/api/logs", params={"name": "run.log"}, content=content).json()["id"])
    assert once_read(service.http, log_id)["state"] == "ready"
    return log_id, service.begin(kind="log", log=log_id, playing=False)


def test_notes_on_areas_are_written_to_files_of_other_programs(service: Service) -> None:
    _, session = opened(service)
    address = f"/api/sessions/{session}/notes"
    corners = [[1.0, 1.0], [1.0, 4.0], [3.0, 4.0], [3.0, 1.0]]  # clockwise, 6 m²
    note = service.http.post(address, json={"text": '=1+1, "wet"\nfloor', "outline": corners, **TIME}).json()
    assert (note["outline"], note["x"], note["y"]) == (corners, pytest.approx(2.0), pytest.approx(2.5))
    service.http.post(address, json={"text": "glass", **PLACE})
    service.http.post(address, json={"text": "a push", **TIME})
    assert service.http.get(address).json()["notes"][0] == note

    answer = service.http.get(f"{address}.geojson")
    assert answer.headers["Content-Type"] == "application/geo+json"
    assert 'filename="run_notes.geojson"' in answer.headers["Content-Disposition"]
    found = answer.json()
    assert (found["type"], found["unit"]) == ("FeatureCollection", "m")
    assert "not longitude and latitude" in found["remark"]
    area, place, moment = found["features"]
    ring = area["geometry"]["coordinates"][0]
    assert (area["geometry"]["type"], len(ring), ring[0]) == ("Polygon", 5, ring[-1])
    assert sorted(ring[:-1]) == sorted(corners)
    turned = sum((x1 - x0) * (y1 + y0) for (x0, y0), (x1, y1) in itertools.pairwise(ring))
    assert turned / -2.0 == pytest.approx(6.0)  # counter-clockwise
    assert area["properties"]["area_m2"] == 6.0
    assert place["geometry"] == {"type": "Point", "coordinates": [1.5, -0.5]}
    assert (moment["geometry"], moment["properties"]["seconds"]) == (None, 2.0)

    table = service.http.get(f"{address}.csv")
    rows = list(csv.DictReader(io.StringIO(table.text, newline="")))
    assert [row["text"] for row in rows] == ['\'=1+1, "wet"\nfloor', "glass", "a push"]
    corners_of_row = re.findall(r"[-0-9.]+ [-0-9.]+", rows[0]["outline"])
    assert [[float(part) for part in corner.split()] for corner in corners_of_row] == ring
    assert (rows[0]["area_m2"], rows[1]["x_m"], rows[2]["x_m"], rows[2]["seconds"]) == ("6.0", "1.5", "", "2.0")


def test_files_of_a_log_in_projected_coordinates_have_them_again(service: Service) -> None:
    east, north = 412_345.25, 5_654_321.5  # UTM; the map is drawn less whole hundreds of metres
    lines = ["angle_min,-1.57", "angle_increment,1.57", "range_max,30", "stamp,x,y,theta,ranges"]
    lines += [f"{n}.0,{east + 0.5 * n},{north},0.0,2.0,3.0,2.0" for n in range(8)]
    content = ("\n".join(lines) + "\n").encode()
    log = service.http.put("/api/logs", params={"name": "utm.csv"}, content=content).json()["id"]
    assert once_read(service.http, log)["state"] == "ready"
    address = f"/api/sessions/{service.begin(kind='log', log=log, playing=False)}/notes"
    corners = [[45.0, 20.0], [48.0, 20.0], [48.0, 24.0]]
    service.http.post(address, json={"text": "kerb", "outline": corners})
    service.http.post(address, json={"text": "start", "x": 45.25, "y": 21.5})
    area, place = service.http.get(f"{address}.geojson").json()["features"]
    assert place["geometry"]["coordinates"] == [east, north]
    ring = [[412_345.0, 5_654_320.0], [412_348.0, 5_654_320.0], [412_348.0, 5_654_324.0], [412_345.0, 5_654_320.0]]
    assert area["geometry"]["coordinates"] == [ring]
    assert area["properties"]["area_m2"] == 6.0
    rows = list(csv.DictReader(io.StringIO(service.http.get(f"{address}.csv").text, newline="")))
    assert (float(rows[1]["x_m"]), float(rows[1]["y_m"])) == (east, north)
    assert [[float(part) for part in one.split()] for one in re.findall(r"[\d.]+ [\d.]+", rows[0]["outline"])] == ring
    assert float(rows[0]["x_m"]) == pytest.approx(412_347.0)
    assert float(rows[0]["y_m"]) == pytest.approx(5_654_321.3333333)


CROSSED = [[0, 0], [2, 2.001], [2, 0], [0, 2]]
IN_LINE = [[-40.61, -47.17], [-39.61, -46.17], [-38.61, -45.17]]  # their products have digits that are lost


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([[0, 0], [1, 1]], ""),
        ([[0, 0]] * 201, ""),
        ([[0, 0], [1, 1], [2, 2]], "not in one line"),
        (IN_LINE, "not in one line"),
        (CROSSED, "sides of the area cross"),
    ],
)
def test_what_is_no_area_is_refused(service: Service, corners: list[list[float]], words: str) -> None:
    _, session = opened(service)
    answer = service.http.post(f"/api/sessions/{session}/notes", json={"text": "flat", "outline": corners})
    assert answer.status_code == 422
    assert words in answer.text


def test_no_cell_of_the_table_is_a_formula() -> None:
    note = Note("n", "ann", "a", 1.0, 2.0, " \t=1+1", Pin(x=1.0, y=2.0))
    (row,) = csv.DictReader(io.StringIO(notes_as_csv([note], MapFrame("=HYPERLINK(1)"))))
    assert (row["text"], row["frame"]) == ("' \t=1+1", "'=HYPERLINK(1)")


def test_notes_are_written_changed_and_deleted(service: Service) -> None:
    log_id, session = opened(service)
    address = f"/api/sessions/{session}/notes"
    first = service.http.post(address, json={"text": "  the door opens ", **TIME})
    assert first.status_code == 201
    assert first.json() | {"text": "the door opens", "mine": True, **TIME, "x": None, "y": None} == first.json()
    second = service.http.post(address, json={"text": "a glass wall", **PLACE}).json()
    assert [note["text"] for note in service.http.get(address).json()["notes"]] == ["the door opens", "a glass wall"]
    moved = service.http.put(f"{address}/{second['id']}", json={"text": "a glass door", **PLACE, **TIME}).json()
    assert (moved["text"], moved["at_s"], moved["x"]) == ("a glass door", 2.0, 1.5)
    assert moved["changed_s"] >= moved["created_s"] == second["created_s"]
    assert service.http.delete(f"{address}/{first.json()['id']}").status_code == 204
    assert [note["id"] for note in service.http.get(address).json()["notes"]] == [second["id"]]
    # They are the log's, not the session's.
    other = service.begin(kind="log", log=log_id, playing=False)
    assert len(service.http.get(f"/api/sessions/{other}/notes").json()["notes"]) == 1
    assert service.http.delete(f"/api/logs/{log_id}").status_code == 204
    assert service.http.get(f"/api/sessions/{other}/notes").json()["notes"] == []


async def test_a_note_is_told_to_all_who_look_at_the_log(service: Service) -> None:
    _, session = await asyncio.to_thread(opened, service)
    link = (await asyncio.to_thread(service.http.post, f"/api/sessions/{session}/links", json={})).json()
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S) as guest:
        shared = (await guest.post(f"/api/shared/{link['token']}/sessions")).json()["id"]
        async with service.connect(shared) as socket:
            watcher = Watcher(socket)
            address = f"/api/sessions/{session}/notes"
            written = await asyncio.to_thread(service.http.post, address, json={"text": "here", **PLACE})
            await watcher.until(lambda: watcher.newest.get("notes", {"changed_s": 0.0})["changed_s"] > 0.0)
            first = watcher.newest["notes"]["changed_s"]
            await asyncio.to_thread(service.http.delete, f"{address}/{written.json()['id']}")
            await watcher.until(lambda: watcher.newest["notes"]["changed_s"] > first)
    service.end_sessions()


def test_guests_of_a_link_and_other_visitors_only_read(service: Service) -> None:
    _, session = opened(service)
    note = service.http.post(f"/api/sessions/{session}/notes", json={"text": "here", **PLACE}).json()
    link = service.http.post(f"/api/sessions/{session}/links", json={}).json()
    with httpx.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S) as guest:
        shared = guest.post(f"/api/shared/{link['token']}/sessions").json()["id"]
        address = f"/api/sessions/{shared}/notes"
        seen = guest.get(address).json()["notes"]
        assert [(one["text"], one["mine"]) for one in seen] == [("here", False)]
        for answer in (
            guest.post(address, json={"text": "me too", **PLACE}),
            guest.put(f"{address}/{note['id']}", json={"text": "there", **PLACE}),
            guest.delete(f"{address}/{note['id']}"),
        ):
            assert (answer.status_code, answer.json()["code"]) == (403, "link.read_only")
        # Another visitor who has the session, but not the note.
        refused = guest.delete(f"/api/sessions/{session}/notes/{note['id']}")
        assert (refused.status_code, refused.json()["code"]) == (403, "note.read_only")
    missing = service.http.delete(f"/api/sessions/{session}/notes/nothing")
    assert (missing.status_code, missing.json()["code"]) == (404, "note.not_found")


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ({"text": "nowhere"}, "note.pin"),
        ({"text": "half", "x": 1.0}, "note.pin"),
        ({"text": "half", "at_s": 1.0}, "note.pin"),
        ({"text": "   ", **PLACE}, "request.invalid"),
        ({"text": "x" * 2001, **PLACE}, "request.invalid"),
        ({"text": "far", "x": 1e9, "y": 0.0}, "request.invalid"),
    ],
)
def test_bad_notes(service: Service, body: dict[str, object], code: str) -> None:
    _, session = opened(service)
    assert service.http.post(f"/api/sessions/{session}/notes", json=body).json()["code"] == code
    service.end_sessions()


def test_one_visitor_leaves_room_for_others(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.annotations.notes.MAX_NOTES_OF_AUTHOR", 2)
    _, session = opened(service)
    answers = [
        service.http.post(f"/api/sessions/{session}/notes", json={"text": str(n), **PLACE}).status_code
        for n in range(3)
    ]
    assert answers == [201, 201, 409]
