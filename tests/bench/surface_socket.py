"""Time from a page's command to the triangles of a depth image at the socket of the 3D view."""

from __future__ import annotations

import asyncio
import io
import json
import struct
import time
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from tests.server.scenes.viser_client import Client, viser_client
from tests.server.service import Service, Watcher, once_read, running, settings_for

QUIET_S = 0.7  #: without triangles, after which none are expected any more: the scene is drawn every 0.25 s at least
ROUNDS = 4


def surface_socket_row(folder: Path, resolution: float) -> str:
    """Return the row of one size of voxels."""
    with TemporaryDirectory() as place, running(settings_for(Path(place))) as service:
        firsts, lasts, triangles, received = asyncio.run(_measured(service, folder, resolution))
    return (
        f"| {100 * resolution:g} cm | {_three(firsts)} | {_three(lasts)} | {np.median(triangles):.0f} | "
        f"{np.median(received) / 1000:.0f} |"
    )


def _three(times: list[float]) -> str:
    """Return the least, the median and the greatest."""
    return f"{min(times):.0f}, {np.median(times):.0f}, {max(times):.0f}"


async def _measured(
    service: Service, folder: Path, resolution: float
) -> tuple[list[float], list[float], list[int], list[int]]:
    """Return of each step the ms to the first and to the last triangles, how many arrived, and the bytes.

    The times of a step are the least of those of all rounds but the first, in which the kernels are loaded.
    """
    log = await asyncio.to_thread(_upload, service, folder)
    wanted = {"kind": "volume", "log": log, "playing": False}
    session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
    cookies = "; ".join(f"{name}={value}" for name, value in service.http.cookies.items())
    times: list[list[tuple[float, float]]] = []
    triangles: list[int] = []
    sizes: list[int] = []
    async with service.connect(session) as socket, viser_client(service.port, session, cookies) as scene:
        page = Watcher(socket)
        reading = asyncio.create_task(_read(page))
        await page.send("surface", values={"resolution": resolution})
        await page.send("volume_look", values={"show": "surface"})
        for number in range(ROUNDS):
            await page.send("seek", index=0)
            await _first_and_last(scene, 0)
            times.append([])
            count = int(page.newest["frame"]["count"])
            for _ in range(count):
                scene.forget()
                began = time.perf_counter()
                await page.send("step")
                first, last = await _first_and_last(scene, 1)
                times[-1].append((1e3 * (first - began), 1e3 * (last - began)))
                if number:
                    triangles.append(sum(_triangles(one) for one in scene.of_type("GlbMessage")))
                    sizes.append(scene.received)
        reading.cancel()
    firsts, lasts = np.min(times[1:], axis=0).T.tolist()
    return firsts, lasts, triangles, sizes


async def _first_and_last(scene: Client, least: int) -> tuple[float, float]:
    """Read the scene's socket until no triangles come any more, at least this many files.

    Return when the first and when the last came.
    """
    first, last = 0.0, time.perf_counter()
    while True:
        known = len(scene.of_type("GlbMessage"))
        try:
            async with asyncio.timeout(QUIET_S if known >= least else 60.0):
                await scene.until(lambda _, known=known: len(scene.of_type("GlbMessage")) > known)
        except TimeoutError:
            return first, last
        last = scene.received_at
        first = first or last


async def _read(page: Watcher) -> None:
    while True:
        await page.read()
        await page.acknowledge()


def _upload(service: Service, folder: Path) -> str:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, file.name)
    answer = service.http.put("/api/logs", params={"name": "depth.zip"}, content=packed.getvalue())
    return str(once_read(service.http, answer.json()["id"])["id"])


def _triangles(message: dict[str, Any]) -> int:
    """Return the number of triangles in the GLB file of a message of viser."""
    data = bytes(message["props"]["glb_data"])
    (length,) = struct.unpack_from("<I", data, 12)
    about = json.loads(data[20 : 20 + length])
    return int(about["accessors"][2]["count"]) // 3
