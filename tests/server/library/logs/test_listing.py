"""Selection and order of listed logs; tags; the pictures of their maps."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import LimitError, MapperError
from mapper.io.logs.summary import LogSummary, ReadingCounts
from mapper.sensors.scan import Topic
from server.library.annotations.tags import MAX_TAGS, clean_tags
from server.library.logs.listing import LogQuery, listed
from server.library.logs.records import Record
from server.library.packs.picture import DARK, LIGHT
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, once_read, running, settings_for


def record(name: str, size: int, duration_s: float | None, *tags: str, topic: str = "/scan") -> Record:
    summary = None
    if duration_s is not None:
        counts = ReadingCounts(1, 0, 0)
        summary = LogSummary(name, "CARMEN FLASER", int(10 * duration_s), 3, duration_s, 180.0, 0.0, 0.1, 10.0,
                             (0.0, 0.0, 0.0), counts, (), (), topics=(Topic(topic, "scan", 1),))  # fmt: skip
    return Record(name, "", name, "upload", "ready", size, summary=summary, tags=tags)


LOGS = [
    record("Corridor.log", 30, 60.0, "night", "building 3"),
    record("atrium.bag", 10, 120.0, "night", topic="/front/scan"),
    record("Basement.log", 20, None),
]


def names(wanted: LogQuery) -> list[str]:
    return [one.name for one in listed(LOGS, wanted).records]


def test_logs_are_found_by_words_and_tags() -> None:
    assert names(LogQuery()) == ["Corridor.log", "atrium.bag", "Basement.log"]
    assert names(LogQuery(words="log")) == ["Corridor.log", "Basement.log"]
    assert names(LogQuery(words="CARMEN front")) == ["atrium.bag"]
    assert names(LogQuery(words="building")) == ["Corridor.log"]
    assert names(LogQuery(tags=("night",))) == ["Corridor.log", "atrium.bag"]
    assert names(LogQuery(words="bag", tags=("night", "building 3"))) == []


def test_logs_come_in_an_order_and_by_pages() -> None:
    assert names(LogQuery(order="name")) == ["atrium.bag", "Basement.log", "Corridor.log"]
    assert names(LogQuery(order="duration")) == ["atrium.bag", "Corridor.log", "Basement.log"]
    assert names(LogQuery(order="size")) == ["Corridor.log", "Basement.log", "atrium.bag"]
    page = listed(LOGS, LogQuery(order="size", offset=1, limit=1))
    assert ([one.name for one in page.records], page.total) == (["Basement.log"], 3)
    assert page.tags == {"building 3": 1, "night": 2}
    many = [replace(LOGS[0], id=str(n), name=f"log {n}") for n in range(700)]
    assert [one.id for one in listed(many, LogQuery(offset=650, limit=100)).records] == [
        str(n) for n in range(650, 700)
    ]


def test_tags_are_cleaned() -> None:
    assert clean_tags([" Night ", "night", "Building   3"]) == ("building 3", "night")
    with pytest.raises(MapperError, match="characters"):
        clean_tags(["  "])
    with pytest.raises(MapperError, match="comma"):
        clean_tags(["a, b"])
    with pytest.raises(LimitError, match="tags"):
        clean_tags([str(n) for n in range(MAX_TAGS + 1)])


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    with running(settings_for(tmp_path / "data")) as service:
        yield f"http://127.0.0.1:{service.port}"


def colours(png: bytes) -> set[tuple[int, ...]]:
    with Image.open(io.BytesIO(png)) as image:
        image.load()
        assert max(image.size) <= 340
        assert image.info["transparency"] == 0
        return {tuple(colour) for colour in np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0).tolist()}


def test_a_log_is_tagged_found_and_has_a_picture(address: str, tmp_path: Path) -> None:
    with httpx.Client(base_url=address, timeout=PATIENCE_S) as ann, httpx.Client(base_url=address) as bob:
        for client in (ann, bob):
            client.get("/api/logs")
        log_id = ann.put("/api/logs", params={"name": "run.log"}, content=carmen(9)).json()["id"]
        log = once_read(ann, log_id)
        assert (log["has_picture"], log["tags"]) == (True, [])
        light = ann.get(f"/api/logs/{log_id}/map.png")
        assert light.headers["content-type"] == "image/png"
        assert LIGHT[2] in colours(light.content)
        dark = ann.get(f"/api/logs/{log_id}/map.png", params={"dark": True})
        assert DARK[2] in colours(dark.content)
        assert bob.get(f"/api/logs/{log_id}/map.png").status_code == 404

        tagged = ann.put(f"/api/logs/{log_id}/tags", json={"tags": ["Night", "hall"]})
        assert (tagged.status_code, tagged.json()["tags"]) == (200, ["hall", "night"])
        assert bob.put(f"/api/logs/{log_id}/tags", json={"tags": ["mine"]}).status_code == 404
        # On the server's own logs each visitor has tags of their own.
        assert bob.put("/api/logs/sample-office/tags", json={"tags": ["first"]}).json()["tags"] == ["first"]
        assert bob.get("/api/logs").json()["tags"] == {"first": 1}
        found = ann.get("/api/logs", params={"q": "run", "tag": ["night"], "limit": 5}).json()
        assert ([one["id"] for one in found["logs"]], found["total"]) == ([log_id], 1)
        assert found["tags"] == {"hall": 1, "night": 1}
        assert ann.get("/api/logs", params={"order": "best"}).status_code == 422

        library = tmp_path / "data" / "library"
        assert (library / "pictures" / f"{log_id}.png").exists()
        assert ann.delete(f"/api/logs/{log_id}").status_code == 204
        assert not list(library.glob(f"*/{log_id}*"))
        assert ann.get("/api/logs").json()["tags"] == {}


def test_tags_and_pictures_outlive_the_service(tmp_path: Path) -> None:
    cookies = None
    log_id = ""
    for run in ("first", "second"):
        with (
            running(settings_for(tmp_path / "data")) as service,
            httpx.Client(base_url=f"http://127.0.0.1:{service.port}", timeout=PATIENCE_S, cookies=cookies) as client,
        ):
            client.get("/api/logs")
            if run == "first":
                log_id = client.put("/api/logs", params={"name": "run.log"}, content=carmen(9)).json()["id"]
                once_read(client, log_id)
                client.put(f"/api/logs/{log_id}/tags", json={"tags": ["kept"]})
                cookies = client.cookies
            log = client.get(f"/api/logs/{log_id}").json()
            assert (log["tags"], log["has_picture"]) == (["kept"], True)
            assert client.get(f"/api/logs/{log_id}/map.png").status_code == 200
