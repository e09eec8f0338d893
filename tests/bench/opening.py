"""``python -m tests.bench opening``: what finding out what a large recording holds costs who opens its map."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.writer import CompressionType, Writer

from mapper.io.export import ros2
from mapper.io.export.topics import Topics
from mapper.sensors.scan import LaserScan
from mapper.simulation import sample_log
from server.client import Client, Log
from tests.bench.service_start import GRIDBLOOM

NAME = "big.mcap"
IMAGES = 390  #: of 1280 × 720 × 3 bytes: 1.08 GB
POLLED_S = 0.3


def opening() -> None:
    """Print elapsed seconds to the first and to the whole map, and CPU, with the inspection beside and without."""
    print("\n| 1.08 GB of images and 600 scans | first map | whole map | contents | CPU after reading | load |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as named:
        folder = Path(named)
        with (folder / NAME).open("wb") as file:
            _write(file)
        for title, inspects in (("map alone", False), ("and what it holds", True)):
            first, whole, contents, cpu = _opened(folder, inspects=inspects)
            print(
                f"| {title} | {first:.1f} s | {whole:.1f} s | {f'{contents:.1f} s' if inspects else ''} "
                f"| {cpu:.1f} s | {os.getloadavg()[0]:.0f} |"
            )


def _write(file: BinaryIO) -> None:
    """Write the recording: images without compression, scans and transforms."""
    log = sample_log()
    pixels = np.random.default_rng(0).integers(0, 255, (720, 1280, 3)).astype(np.uint8)
    writer = Writer(file, compression=CompressionType.NONE)
    writer.start("ros2", "gridbloom")
    topics = Topics(writer, frozenset())
    for index, stamp in enumerate(log.stamps_ns.tolist()):
        x, y, yaw = log.trajectory("true").poses[index].tolist()
        edges = [("odom", "base_link", (x, y, yaw), False), ("base_link", "laser", (0.0, 0.0, 0.0), False)]
        topics.send("/tf", "tf2_msgs/msg/TFMessage", stamp, ros2.transforms(stamp, edges))
        scan = log.scan(index)
        assert isinstance(scan, LaserScan)
        topics.send("/scan", "sensor_msgs/msg/LaserScan", stamp, ros2.laser_scan(stamp, "laser", scan))
        if index < IMAGES:
            image = ros2.image(stamp, "camera", np.roll(pixels, index))
            topics.send("/camera", "sensor_msgs/msg/Image", stamp, image)
    writer.finish()  # type: ignore[no-untyped-call] # mcap's writer has no types there


def _opened(folder: Path, *, inspects: bool) -> tuple[float, float, float, float]:
    """Return seconds to the first map, to the whole map and to the contents, and CPU, all after the log was read."""
    with tempfile.TemporaryDirectory() as data:
        service = subprocess.Popen(
            [sys.executable, "-c", GRIDBLOOM, "serve", "--port", "0", "--data-dir", data, "--logs-dir", str(folder)],
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert service.stdout is not None
            address = service.stdout.readline().split()[-1]
            with Client(address.rstrip("/")) as client:
                log = _found(client)
                began, used = time.perf_counter(), _cpu_of_all_s(service.pid)
                session = client.open(log, playing=False)
                contents = 0.0

                def inspect() -> None:
                    nonlocal contents
                    while client._answer("GET", f"/api/sessions/{session.id}/contents").status_code == 202:
                        time.sleep(POLLED_S)
                    contents = time.perf_counter() - began

                inspecting = threading.Thread(target=inspect)
                if inspects:
                    inspecting.start()
                client.seek(session, 1)
                first = time.perf_counter() - began
                client.seek(session)
                whole = time.perf_counter() - began
                if inspects:
                    inspecting.join()
                return first, whole, contents, _cpu_of_all_s(service.pid) - used
        finally:
            service.terminate()
            service.wait()


def _found(client: Client) -> Log:
    """Return the log of the folder once it was read."""
    while not (found := [one for one in client.logs() if one.name == NAME]):
        time.sleep(POLLED_S)
    return client.wait(found[0])


def _cpu_of_all_s(pid: int) -> float:
    """Return the CPU time of a process, of its children, and of those that have ended (proc_pid_stat(5))."""
    total, processes = 0.0, [pid]
    while processes:
        folder = Path(f"/proc/{processes.pop()}")
        fields = (folder / "stat").read_text().rpartition(")")[2].split()
        total += sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
        for task in folder.glob("task/*/children"):
            processes += map(int, task.read_text().split())
    return total
