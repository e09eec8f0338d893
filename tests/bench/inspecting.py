"""``python -m tests.bench inspecting``: remote inspection of logs: seeking, ten clients, one changed region."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import httpx
import numpy as np
import viser
from viser._scene_api import _encode_image_binary  # what ViserServer sends of a picture, to count its bytes
from websockets.sync.client import connect

from mapper.grid import TILE, CellBox, GridGeometry, OccupancyGrid
from mapper.io.export.recording import write_mcap
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.stream.grid_layer import TilePicture, picture_range
from server.stream.protocol import TILES
from tests.bench.feel import new_page
from tests.bench.stopwatch import Laps, laps
from tests.browser.looking import frame, settled_digest, until
from tests.browser.running import free_port, running_chromium, running_server
from tests.server.stream.frame_decoding import decode_frame, encode_frame

SIDE = 2048
SEEKS = 40
PEOPLE = 10
PATIENCE_S = 120.0


def seeking(log: ScanLog) -> Laps:
    """Return the laps from a moment chosen on the timeline to the whole map of that moment, painted."""
    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        logs.mkdir()
        with (logs / "long.mcap").open("wb") as file:
            write_mcap(file, log)
        with running_server(Path(folder), "--logs-dir", str(logs)) as server, running_chromium() as browser:
            page = new_page(browser)
            page.goto(f"{server}/logs.html")
            page.locator(".log-card", has_text="long").get_by_role("button", name="Open map").click()
            page.wait_for_function("() => window.gridbloom && gridbloom.connection.store.frame.peek()", timeout=60_000)
            timeline = page.get_by_role("slider", name="Scans in the map")
            timeline.focus()
            page.keyboard.press("End")
            until("the end of the log", lambda: frame(page)["index"] == frame(page)["count"])
            settled_digest(page)
            places = np.random.default_rng(7).uniform(0.02, 0.98, SEEKS)

            box = timeline.bounding_box()
            assert box is not None

            def seek(i: int) -> None:
                page.mouse.click(box["x"] + float(places[i]) * box["width"], box["y"] + 0.5 * box["height"])

            return laps(page, ["pointerdown"], "whole map", seek, SEEKS)


def process_of(address: str) -> int:
    """Return the process of a service."""
    port = int(address.rsplit(":", 1)[1])
    return next(
        int(folder.name)
        for folder in Path("/proc").iterdir()
        if folder.name.isdigit() and f"--port\0{port}\0".encode() in _read(folder / "cmdline")
    )


def memory_of(address: str) -> float:
    """Return the megabytes that the processes of a service hold: the resident sets, shared pages counted once each."""
    return sum(_proportional_kb(process) for process in _family(process_of(address))) / 1024


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:  # it ended meanwhile
        return b""


def _proportional_kb(process: int) -> int:
    for line in _read(Path(f"/proc/{process}/smaps_rollup")).decode().splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1])
    return 0


def _family(root: int) -> Iterator[int]:
    yield root
    for task in Path(f"/proc/{root}/task").iterdir():
        for child in _read(task / "children").split():
            yield from _family(int(child))


def ten_people(files: list[Path]) -> tuple[float, float]:
    """Return the megabytes of the service before anybody came, and while ten people watch ten logs at their ends."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        logs = Path(folder) / "logs"
        logs.mkdir()
        for path in files:
            shutil.copy(path, logs)
        address = stack.enter_context(running_server(Path(folder) / "data", "--logs-dir", str(logs)))
        before = memory_of(address)
        for path in files:
            person = stack.enter_context(httpx.Client(base_url=address, timeout=PATIENCE_S))
            _at_the_end(person, address, path, stack)
        time.sleep(2.0)
        return before, memory_of(address)


def _at_the_end(person: httpx.Client, address: str, path: Path, stack: ExitStack) -> None:
    """Open a log as a visitor of one's own, go to its end and wait for the map."""
    deadline = time.monotonic() + PATIENCE_S
    while True:
        known = next(log for log in person.get("/api/logs").json()["logs"] if log["name"] == path.name)
        known = person.get(f"/api/logs/{known['id']}").json()
        if known["state"] == "ready":
            break
        if known["state"] == "failed" or time.monotonic() > deadline:
            raise RuntimeError(f"{path.name}: {known}")
        time.sleep(0.05)
    answer = person.post("/api/sessions", json={"kind": "log", "log": known["id"], "playing": False})
    answer.raise_for_status()
    stream = stack.enter_context(
        connect(
            f"{address.replace('http', 'ws', 1)}/api/sessions/{answer.json()['id']}/stream",
            subprotocols=["gridbloom.v3"],  # type: ignore[list-item]
            compression=None,
            max_size=None,
            additional_headers={"Cookie": "; ".join(f"{k}={v}" for k, v in person.cookies.items())},
        )
    )
    stream.send(json.dumps({"type": "seek", "index": known["scans"], "id": 1}))
    while True:
        said = stream.recv(PATIENCE_S)
        if isinstance(said, bytes):
            stream.send(json.dumps({"type": "ack", "seq": decode_frame(said).seq}))
        elif json.loads(said).get("index") == known["scans"]:
            return


def one_region() -> tuple[tuple[int, float], tuple[int, float]]:
    """Return bytes and milliseconds of one changed tile of a map of 2,048 × 2,048 cells: ours, and viser's picture."""
    random = np.random.default_rng(7)
    grid = OccupancyGrid(GridGeometry(0.05, SIDE, SIDE))
    smooth = np.kron(random.normal(0.0, 1.0, (SIDE // 16, SIDE // 16)), np.ones((16, 16)))
    grid.log_odds[:] = np.clip(smooth + random.normal(0.0, 0.1, smooth.shape), -2.0, 3.5)
    grid.observed[:] = True
    picture = TilePicture(grid.geometry, *picture_range(MappingConfig()))
    picture.update(grid, CellBox(0, SIDE, 0, SIDE))
    picture.publish()
    row = col = SIDE // 2
    box = CellBox(row, row + TILE, col, col + TILE)
    ours, size = [], 0
    for _ in range(30):
        grid.log_odds[row : row + TILE, col : col + TILE] = random.normal(0.0, 1.0, (TILE, TILE))
        began = time.perf_counter()
        picture.update(grid, box)
        picture.publish()
        tiles = list(picture.payloads(np.array([[row // TILE, col // TILE]])))
        size = len(encode_frame(TILES, tiles, layer=1, epoch=1, seq=1))
        ours.append(time.perf_counter() - began)
    shown = np.repeat((127 - picture.cells.astype(np.int16)).astype(np.uint8)[:, :, np.newaxis], 3, axis=2)
    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    theirs = []
    for _ in range(5):
        began = time.perf_counter()
        server.scene.add_image("/map", shown, 100.0, 100.0, format="png")
        theirs.append(time.perf_counter() - began)
    server.stop()
    _, whole = _encode_image_binary(shown, "png")
    return (size, 1e3 * min(ours)), (len(whole), 1e3 * min(theirs))


def inspecting(long_log: ScanLog) -> None:
    """Print the table."""
    took = seeking(long_log)
    rows = [
        (f"seek in {long_log.n_scans:,} scans × {long_log.n_beams} → painted, p95", took.told(), "300 ms", "100 ms")
    ]
    data = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    files = sorted([*data.glob("carmen/*.log.gz"), *data.glob("breezyslam/*.gz"), *data.glob("bags/scans_demo.bag")])
    if len(files) >= PEOPLE:
        before, after = ten_people(files[-PEOPLE:])
        what = f"memory while {PEOPLE} people inspect {PEOPLE} logs ({before:.0f} MiB before)"
        rows.append((what, f"{after:.0f} MiB", "1 GiB", "500 MiB"))
    else:
        print("ten logs: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
    (size, ms), (whole_size, whole_ms) = one_region()
    rows += [
        (f"a tile of {SIDE}²: bytes", f"{whole_size:,} / {size:,} = {whole_size / size:.0f} × less", "20 ×", "100 ×"),
        ("the same, server time", f"{whole_ms:.0f} / {ms:.2f} ms = {whole_ms / ms:.0f} × less", "20 ×", "100 ×"),
    ]
    print("\n| uploaded logs; a tile beside viser's picture | measured | at least | aim |\n|---|---|---|---|")
    for row in rows:
        print(f"| {' | '.join(row)} |")
