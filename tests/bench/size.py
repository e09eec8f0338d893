"""``python -m tests.bench size``: large recordings with a camera in them, and the first seek in a long log. Linux only.

Peak memory is the resident set's largest value (VmHWM, proc_pid_status(5)); CPU is user and system time.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from mapper.io.logs import open_log
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from server.upload_client import measured, sent
from tests.bench.inspecting import process_of
from tests.bench.service_start import cpu_s
from tests.browser.running import running_server
from tests.mapper.io.logs import camera_recordings
from tests.mapper.io.logs.camera_recordings import CameraRun
from tests.server.service import Watcher, stream_at

GRIDBLOOM = str(Path(sys.executable).with_name("gridbloom"))
LOOK_S = 0.05
PATIENCE_S = 3600.0


@dataclass(frozen=True, slots=True)
class Cost:
    """Time and memory of a process, and its output."""

    peak_mb: float
    cpu_s: float
    elapsed_s: float
    output: dict[str, Any]

    def told(self) -> str:
        """Return the figures as cells of a table."""
        return f"{self.peak_mb:.0f} MB | {self.cpu_s:.1f} s | {self.elapsed_s:.1f} s"


def peak_mb_of(pid: int) -> float:
    """Return the most memory that a process has held, 0 where it is gone."""
    try:
        found = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    except OSError:
        return 0.0
    return int(found[1]) / 1024 if found else 0.0


def command(*arguments: str) -> Cost:
    """Run ``gridbloom`` with ``--json`` in a process of its own."""
    began = time.perf_counter()
    process = subprocess.Popen([GRIDBLOOM, *arguments, "--json"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    peak = 0.0
    while True:
        peak = max(peak, peak_mb_of(process.pid))
        pid, status, used = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        time.sleep(LOOK_S)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"gridbloom {' '.join(arguments)} ended with {process.returncode}")
    output = json.loads(process.stdout.read())
    process.stdout.close()
    return Cost(peak, used.ru_utime + used.ru_stime, time.perf_counter() - began, output)


def mapping(folder: Path, kinds: tuple[str, ...] = ("mcap", "bag", "db3"), size: int = 2_000_000_000) -> None:
    """Print what the command line takes to map 50,000 scans of 1,080 beams in files with a camera."""
    print("| gridbloom map, 50,000 × 1,080 | size | peak memory | CPU | elapsed |\n|---|---|---|---|---|")
    for kind in kinds:
        path = camera_recordings.write(folder / f"camera.{kind}", kind, CameraRun(50_000).for_bytes(size))
        cost = command("map", str(path), "--quiet")
        assert cost.output["scans"] == 50_000
        print(f"| {kind} | {path.stat().st_size / 1e9:.1f} GB | {cost.told()} |", flush=True)
        path.unlink()


def uploading(folder: Path, size: int = 5_000_000_000) -> None:
    """Print what it takes to map a file of 5 GB by the command line, and to send it to a service that reads it."""
    path = camera_recordings.write(folder / "camera.mcap", "mcap", CameraRun(50_000).for_bytes(size))
    cost = command("map", str(path), "--quiet")
    print("\n| MCAP with a camera | size | peak memory | CPU | elapsed |\n|---|---|---|---|---|")
    print(f"| gridbloom map | {path.stat().st_size / 1e9:.1f} GB | {cost.told()} |", flush=True)
    allowed = {"GRIDBLOOM_MAX_UPLOAD_BYTES": str(2 * size)}
    with running_server(folder / "data", environment=allowed) as address, httpx.Client(base_url=address) as client:
        service = process_of(address)
        shares: dict[str, set[float]] = {"sent": set(), "read": set()}
        began = time.perf_counter()
        sent(client, path, path.name, *measured(path), shares["sent"].add, 1.0)
        sent_s = time.perf_counter() - began
        log: dict[str, Any] = {"state": "queued"}
        reader_mb = 0.0
        while log["state"] in ("queued", "reading"):
            log = next(one for one in client.get("/api/logs").json()["logs"] if one["source"] == "upload")
            shares["read"].add(log["progress"])
            reader_mb = max([reader_mb, *(peak_mb_of(pid) for pid in children(service))])
            time.sleep(LOOK_S)
        assert (log["state"], log["scans"]) == ("ready", 50_000), log
        read_s = time.perf_counter() - began - sent_s
        for what, values, peak, seconds in (
            ("upload, the service", shares["sent"], peak_mb_of(service), sent_s),
            ("then reading, its process", shares["read"], reader_mb, read_s),
        ):
            print(f"| {what} ({len(values)} values of progress) | | {peak:.0f} MB | | {seconds:.1f} s |", flush=True)


def children(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    return [int(one) for task in Path(f"/proc/{pid}/task").iterdir() for one in (task / "children").read_text().split()]


async def _first_seek(address: str, session: str) -> tuple[float, float, float]:
    """Seek the end of a log; return the seconds until something of it can be painted, until all can, and of CPU."""
    async with stream_at(f"ws{address.removeprefix('http')}/api/sessions/{session}/stream") as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.complete and "frame" in watcher.newest)
        count, frames = watcher.newest["frame"]["count"], watcher.frames
        began, cpu_began = time.perf_counter(), cpu_s(process_of(address))
        await watcher.send("seek", index=count)
        await watcher.until(lambda: watcher.frames > frames)
        painted_s = time.perf_counter() - began
        await watcher.until(lambda: watcher.newest["frame"]["index"] == count and watcher.complete)
        return painted_s, time.perf_counter() - began, cpu_s(process_of(address)) - cpu_began


def _mapped(path: Path) -> tuple[float, float]:
    """Return the seconds and the CPU seconds of mapping a log that is in memory, as ``gridbloom map`` does."""
    log = open_log(path)
    config = MappingConfig()
    grid = grid_for(log, config)
    integrate_log(grid, log, config, None, 0, 0)
    began, cpu_began = time.perf_counter(), time.process_time()
    integrate_log(grid, log, config)
    return time.perf_counter() - began, time.process_time() - cpu_began


def seeking(folder: Path, n_scans: int = 40_000) -> None:
    """Print the first seek of a log's end, while its doctor was asked for, as a ratio to mapping it."""
    (folder / "logs").mkdir()
    run = CameraRun(n_scans, image_bytes=1, scans_per_image=n_scans)
    path = camera_recordings.write(folder / "logs" / "long.mcap", "mcap", run)
    mapped, mapped_cpu = _mapped(path)
    with (
        running_server(folder / "data", "--logs-dir", str(path.parent)) as address,
        httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
    ):
        log = next(one for one in client.get("/api/logs").json()["logs"] if one["name"] == path.name)
        session = client.post("/api/sessions", json={"kind": "log", "log": log["id"], "playing": False}).json()["id"]
        doctor = threading.Thread(target=client.get, args=(f"/api/sessions/{session}/doctor",), daemon=True)
        doctor.start()
        time.sleep(2.0)  # it is in the middle of its work
        painted_s, complete_s, seek_cpu = asyncio.run(_first_seek(address, session))
        peak = peak_mb_of(process_of(address))
        client.delete(f"/api/sessions/{session}")
        doctor.join(PATIENCE_S)
    columns = (
        f"first seek, {n_scans} × {run.n_beams}", "gridbloom map, mapping", "its CPU", "first paint", "complete",
        "ratio", "CPU of the service", "ratio", "its peak memory",
    )  # fmt: skip
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    print(
        f"| with the doctor asked for | {mapped:.1f} s | {mapped_cpu:.1f} s | {painted_s:.2f} s | {complete_s:.1f} s | "
        f"{complete_s / mapped:.2f} × | {seek_cpu:.1f} s | {seek_cpu / mapped_cpu:.2f} × | {peak:.0f} MB |",
        flush=True,
    )


def size() -> None:
    """Print the tables."""
    with tempfile.TemporaryDirectory(prefix="size-") as folder:
        seeking(Path(folder))
    with tempfile.TemporaryDirectory(prefix="size-") as folder:
        mapping(Path(folder))
    with tempfile.TemporaryDirectory(prefix="size-") as folder:
        uploading(Path(folder))
