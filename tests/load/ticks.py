"""Processor time of a lab session per frame, by part.

The sessions run in this process as the service runs them (registry, host, scheduler, threads, hub), each with a client
that takes and acknowledges what the hub has for it ten times a second. The time of a part is the processor time of the
threads inside its functions, less that of the parts within; counting costs about a microsecond for each call. What no
part counts is the event loop: tasks, timers, the hand-over to threads and back.
"""

from __future__ import annotations

import asyncio
import logging
import struct
import tempfile
import time
from pathlib import Path

import structlog

from mapper.simulation import explorer as exploring
from mapper.simulation import faults as faulty
from mapper.simulation import lidar, live_map, recording, simulation
from mapper.simulation.kernels import driving
from server.sessions import SessionRegistry, computation, host, model
from server.settings import Settings
from server.sources.simulation_kind import simulation_plan
from server.stream.grid_layer import GridLayer
from server.stream.hub import Client, Hub
from server.work.scheduler import Scheduler
from tests.load.spans import Spans

SECONDS = 10.0
PERIOD_S = 0.1  #: between two looks of a viewer
PARTS = (
    "cast", "noise and scan", "polished walls", "physics, steering", "explorer", "record", "integrate", "quantise",
    "messages", "JSON", "tiles", "scheduler", "tick, the rest", "event loop, hand-over",
)  # fmt: skip


def _counted(spans: Spans) -> None:
    """Count every part of a tick."""
    spans.count("cast", lidar, "cast_rays")
    spans.count("noise and scan", simulation, "measure")
    spans.count("polished walls", live_map, "lengthened")
    spans.count("polished walls", faulty, "reflected_away")
    spans.count("physics, steering", driving, "drive")
    spans.count("explorer", exploring.Explorer, "plan")
    spans.count("explorer", exploring.Explorer, "note")
    spans.count("record", recording.Recording, "append")
    spans.count("integrate", live_map, "integrate_scan")
    spans.count("quantise", GridLayer, "update")
    spans.count("messages", computation, "frame_message")
    spans.count("messages", model, "scan_of")
    spans.count("JSON", Hub, "publish")
    spans.count("JSON", Hub, "frame_text")
    spans.count("tiles", Client, "take")
    spans.count("scheduler", Scheduler, "request")
    spans.count("scheduler", Scheduler, "release")
    spans.count("tick, the rest", host, "compute_tick")


async def _view(client: Client, until: float) -> int:
    """Look ten times a second; return the number of looks at which there was a new frame."""
    seen = 0
    while (now := time.monotonic()) < until:
        frames = [one for one in client.take() if isinstance(one, bytes)]
        if frames:
            seen += 1
            client.acknowledge(struct.unpack_from("<BBHIII", frames[-1])[4])
        await asyncio.sleep(max(0.0, now + PERIOD_S - time.monotonic()))
    return seen


async def _run(count: int, spans: Spans, folder: Path) -> tuple[int, int, float, float]:
    """Run so many sessions; return the frames seen, the ticks computed, the processor time and the wall time."""
    settings = Settings(data_dir=folder, max_sessions=count, max_sessions_per_visitor=count, max_total_cells=1 << 30)
    registry = SessionRegistry(settings)
    await registry.start()
    plans = [simulation_plan("office", seed, max_story_s=30.0) for seed in range(count)]
    sessions = [await registry.begin(plan, "load", address="127.0.0.1") for plan in plans]
    clients = [session.join() for session in sessions]
    await asyncio.gather(*(_view(client, time.monotonic() + 2.0) for client in clients))
    spans.reset()
    ticks = sum(session.hub.frame_number for session in sessions)
    cpu, wall = time.process_time(), time.monotonic()
    seen = await asyncio.gather(*(_view(client, wall + SECONDS) for client in clients))
    cpu, wall = time.process_time() - cpu, time.monotonic() - wall
    ticks = sum(session.hub.frame_number for session in sessions) - ticks
    await registry.shutdown()
    return sum(seen), ticks, cpu, wall


def ticks(*counts: int) -> None:
    """Print where the time of a frame goes, for these numbers of sessions."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR))
    rows: dict[str, list[float]] = {name: [] for name in PARTS}
    heads = []
    for count in counts or (1, 16, 64):
        spans = Spans()
        _counted(spans)
        with tempfile.TemporaryDirectory() as folder:
            try:
                seen, computed, cpu, wall = asyncio.run(_run(count, spans, Path(folder)))
            finally:
                spans.close()
        spans.seconds[PARTS[-1]] = cpu - sum(spans.seconds.values())
        for name in PARTS:
            rows[name].append(1e6 * spans.seconds[name] / seen)
        heads.append((count, seen / count / wall, computed / count / wall, cpu / wall, 1e6 * cpu / seen))
    print("µs of processor time per frame that a viewer sees, by part")
    print(f"{'sessions':<24}" + "".join(f"{count:>9}" for count, *_ in heads))
    for name, values in rows.items():
        print(f"{name:<24}" + "".join(f"{value:>9.0f}" for value in values))
    for at, name in enumerate(("frames/s", "ticks/s", "cores", "µs per frame"), start=1):
        print(f"{name:<24}" + "".join(f"{head[at]:>9.{0 if at == 4 else 2}f}" for head in heads))
