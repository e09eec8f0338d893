"""``python -m tests.bench reading``: upload and read, beside the bare reader library on the same file, as ratios.

Bare means: each message that a map needs is found and decoded, and nothing is kept. For a bag that is rosbags alone;
for MCAP the mcap library, and rosbags' decoder on what it yields; for CARMEN, which has no library, Python's floats.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from rosbags import rosbag1

from mapper.io.logs import open_log
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND
from tests.server.service import Service, running, settings_for

WANTED = frozenset({"sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"})
ROUNDS = 7


def messages(n_scans: int = 4000, n_beams: int = 720) -> list[recorded.Said]:
    """A run with odometry and tf at twice the rate of its scans."""
    rng = np.random.default_rng(1)
    start = 1_700_000_000 * SECOND
    said = [recorded.transform(start, "base_link", "laser", 0.2, topic="/tf_static")]
    for i in range(2 * n_scans):
        at = start + i * SECOND // 20
        said += [recorded.odometry(at, i / 100, 0.0, 0.0), recorded.transform(at, "odom", "base_link", i / 100)]
        if i % 2 == 0:
            said.append(recorded.scan(at, rng.uniform(0.5, 29.0, n_beams), angles=(-2.35, 4.7 / n_beams)))
    return said


def carmen(n_scans: int = 4000, n_beams: int = 361) -> bytes:
    """The same as CARMEN writes it."""
    rng = np.random.default_rng(1)
    lines = []
    for i in range(n_scans):
        readings = " ".join(f"{r:.2f}" for r in rng.uniform(0.5, 29.0, n_beams))
        pose = f"{i / 100} 0.0 0.0"
        lines.append(f"ODOM {pose} 0 0 0 {i / 10} host {i / 10}\n")
        lines.append(f"FLASER {n_beams} {readings} {pose} {pose} {i / 10} host {i / 10}\n")
    return "".join(lines).encode()


def bare_bag(path: Path) -> None:
    """rosbags alone."""
    with rosbag1.Reader(path) as reader:
        wanted = [one for one in reader.connections if one.msgtype in WANTED]
        for connection, _, data in reader.messages(wanted):
            recorded.store(1).deserialize_ros1(data, connection.msgtype)


def bare_mcap(path: Path) -> None:
    """The mcap library alone."""
    with path.open("rb") as file:
        for schema, _, message in make_reader(file).iter_messages():
            if schema is not None and schema.name in WANTED:
                recorded.store(2).deserialize_cdr(message.data, schema.name)


def bare_carmen(path: Path) -> None:
    """Python's float alone."""
    for line in path.read_bytes().splitlines():
        fields = line.split()
        [float(field) for field in fields[1:-2]]


def sent(service: Service, path: Path) -> None:
    """Upload the file and wait until it was read."""
    answer = service.http.put("/api/logs", params={"name": path.name}, content=path.read_bytes()).json()
    while (log := service.http.get(f"/api/logs/{answer['id']}").json())["state"] in ("queued", "reading"):
        time.sleep(0.01)
    if log["state"] != "ready":
        raise RuntimeError(str(log["error"]))
    service.http.delete(f"/api/logs/{answer['id']}")


def best_s(works: Sequence[Callable[[], object]]) -> list[float]:
    """Return the seconds that each work takes, the best of some rounds in which each has its turn."""
    best = [float("inf")] * len(works)
    for _ in range(ROUNDS):
        for index, work in enumerate(works):
            began = time.perf_counter()
            work()
            best[index] = min(best[index], time.perf_counter() - began)
    return best


def reading() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        said = messages()
        files = {
            "CARMEN": (here / "run.log", bare_carmen),
            "ROS 1 bag": (recorded.write_bag(here / "run.bag", said), bare_bag),
            "MCAP (zstd)": (here / "run.mcap", bare_mcap),
        }
        files["CARMEN"][0].write_bytes(carmen())
        files["MCAP (zstd)"][0].write_bytes(recorded.mcap_bytes(said))
        print(
            "| log | size | bare reader | read | upload and read | read, ratio | upload and read, ratio |\n"
            "|---|---|---|---|---|---|---|"
        )
        with running(settings_for(here / "data")) as service:
            sent(service, files["CARMEN"][0])  # the process that reads starts with the first log
            for name, (path, bare) in files.items():
                megabytes = path.stat().st_size / 1e6
                times = best_s([partial(bare, path), partial(open_log, path), partial(sent, service, path)])
                rates = " | ".join(f"{megabytes / t:.0f} MB/s" for t in times)
                ratios = " | ".join(f"{times[0] / t:.2f} ×" for t in times[1:])
                print(f"| {name} | {megabytes:.1f} MB | {rates} | {ratios} |")
