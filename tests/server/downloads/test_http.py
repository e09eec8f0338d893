"""Map files over HTTP: yaml and pgm are of one map, and a download ends with its client."""

from __future__ import annotations

import asyncio
import itertools
import re
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import yaml

from mapper.io.maps import load_map, pgm_bytes
from mapper.io.maps.images import Bands
from server.downloads import file_stem
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, Service, Watcher, once_read, until


def saved(folder: Path, answer: httpx.Response) -> Path:
    """Save a download under the name that it states, as a browser does."""
    assert answer.status_code == 200, answer.text
    found = re.fullmatch(r'attachment; filename="([^"/]+)"', answer.headers["content-disposition"])
    assert found
    path = folder / found[1]
    assert not path.exists(), "nothing is overwritten"
    path.write_bytes(answer.content)
    return path


async def test_the_files_of_an_instant_are_of_one_map_while_it_grows(service: Service, tmp_path: Path) -> None:
    session_id = service.begin(kind="simulation", world="office", seed=5)
    session: Any = service.state.sessions.get(session_id)
    pairs = []
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        for number, kinds in enumerate((("pgm", "yaml"), ("yaml", "pgm"))):
            paths = {}
            for kind in kinds:
                address = f"/api/sessions/{session_id}/map.{kind}?at=take-{number}"
                paths[kind] = saved(tmp_path, await asyncio.to_thread(service.http.get, address))
                if kind == kinds[0]:
                    shape, cells = session.model.grid.geometry.shape, int(session.model.grid.observed.sum())
                    # The sensor reaches farther: the map grows and moves its corner.
                    await watcher.send("parameters", values={"resolution": 0.05 - 0.01 * (number + 1)})
                    await watcher.until(lambda: session.model.grid.geometry.shape != shape)  # noqa: B023
                    frames = watcher.frames
                    await watcher.until(lambda: watcher.frames > frames + 3)  # noqa: B023
                    assert int(session.model.grid.observed.sum()) != cells
            assert (paths["pgm"].name, paths["yaml"].name) == (
                f"office_take-{number}.pgm",
                f"office_take-{number}.yaml",
            )
            pairs.append(paths)
    for paths in pairs:
        loaded = load_map(paths["yaml"])
        assert yaml.safe_load(paths["yaml"].read_text())["image"] == paths["pgm"].name
        assert loaded.description.frame == "map"
        assert pgm_bytes(loaded.grid) == paths["pgm"].read_bytes()
    first, second = (load_map(paths["yaml"]).grid.geometry for paths in pairs)
    assert (first.resolution, second.resolution) == (0.05, 0.04)


def test_names_are_those_of_the_log(service: Service) -> None:
    answer = service.http.put("/api/logs?name=Büro 2.log.gz", content=carmen(10))
    log = once_read(service.http, answer.json()["id"])
    session = service.begin(kind="log", log=log["id"])
    for ending in ("pgm", "yaml", "png"):
        answer = service.http.get(f"/api/sessions/{session}/map.{ending}")
        expected = f"attachment; filename=\"Buro_2.{ending}\"; filename*=UTF-8''B%C3%BCro_2.{ending}"
        assert answer.headers["content-disposition"] == expected
    answer = service.http.get(f"/api/sessions/{session}/map.pgm", headers={"Accept-Encoding": "identity"})
    assert int(answer.headers["content-length"]) == len(answer.content)
    image = yaml.safe_load(service.http.get(f"/api/sessions/{session}/map.yaml").text)["image"]
    assert image == f"{file_stem(log['name'])}.pgm" == "Büro_2.pgm"


def test_an_instant_that_is_no_longer_kept_is_said(service: Service) -> None:
    session = service.begin(kind="simulation", world="room", seed=6)
    address = f"/api/sessions/{session}/map"
    for number in range(5):
        assert service.http.get(f"{address}.pgm?at=n{number}").status_code == 200
    answer = service.http.get(f"{address}.pgm?at=n0")
    assert (answer.status_code, answer.json()["code"]) == (410, "map.snapshot_gone")
    assert yaml.safe_load(service.http.get(f"{address}.yaml?at=n0").text)["image"] == "room_n0.pgm"
    answer = service.http.get(f"{address}.pgm?at=../../x")
    assert (answer.status_code, answer.json()["code"]) == (422, "request.invalid")


def test_a_disconnected_client_releases_its_slot_and_ends_the_work(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = service.begin(kind="simulation", world="room", seed=7)
    asked, bands = threading.Event(), []

    def endless(_: object) -> Bands:
        def made() -> Iterator[np.ndarray[tuple[int, ...], np.dtype[np.uint8]]]:
            while True:
                bands.append(np.zeros((1, 10), np.uint8))
                asked.set()
                yield bands[-1]

        return made()

    slots = service.state.downloads.slots
    monkeypatch.setattr("server.http.routes.maps.probability_pixels", endless)
    with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE_S) as leaving:
        request = f"GET /api/sessions/{session}/map.png HTTP/1.1\r\nHost: 127.0.0.1:{service.port}\r\n\r\n"
        leaving.sendall(request.encode())
        assert asked.wait(PATIENCE_S)
    until(lambda: slots.taken == 0)
    made = len(bands)
    assert service.http.get(f"/api/sessions/{session}/map.pgm").status_code == 200, "its session goes on"
    assert len(bands) == made


def test_the_third_download_waits_for_a_slot_and_is_refused_after_a_time(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = service.begin(kind="simulation", world="room", seed=8)
    slots = service.state.downloads.slots
    release = threading.Event()

    def slow(_: object) -> Bands:
        release.wait(PATIENCE_S)
        return [np.zeros((1, 10), np.uint8)]

    monkeypatch.setattr("server.http.routes.maps.probability_pixels", slow)
    monkeypatch.setattr(slots, "_wait_s", 0.2)
    answers: list[httpx.Response] = []

    def take() -> None:
        with httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S) as visitor:  # of the same address
            answers.append(visitor.get(f"/api/sessions/{session}/map.png"))

    threads = [threading.Thread(target=take) for _ in range(2)]
    try:
        for thread in threads:
            thread.start()
        until(lambda: slots.taken == 2)
        answer = service.http.get(f"/api/sessions/{session}/map.pgm")
        assert (answer.status_code, answer.json()["code"]) == (429, "download.too_many")
        assert answer.headers["retry-after"]
        monkeypatch.setattr(slots, "_wait_s", PATIENCE_S)
        threads.append(threading.Thread(target=take))
        threads[-1].start()
        until(lambda: len(slots._waiting) == 1)
    finally:
        release.set()
        for thread in threads:
            thread.join()
    assert [answer.status_code for answer in answers] == [200] * 3


def test_a_client_that_reads_nothing_loses_its_slot(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    session = service.begin(kind="simulation", world="room", seed=9)
    noise = np.random.default_rng(2).integers(0, 256, (1, 1 << 16), dtype=np.uint8)
    slots = service.state.downloads.slots
    taken: list[int] = []

    def endless(_: object) -> Bands:
        taken.append(slots.taken)
        return itertools.repeat(noise, 2000)

    monkeypatch.setattr("server.http.routes.maps.probability_pixels", endless)
    monkeypatch.setattr("server.downloads.response.STALLED_S", 0.2)
    with service.http.stream("GET", f"/api/sessions/{session}/map.png") as answer:
        assert answer.status_code == 200
        until(lambda: slots.taken == 0)
        assert taken == [1]
        with pytest.raises(httpx.RemoteProtocolError):  # it cannot be taken for the whole file
            answer.read()
