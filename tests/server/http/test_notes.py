"""Notes on a log: written, changed, deleted, seen through a link, and gone with the log."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import httpx
import pytest

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
