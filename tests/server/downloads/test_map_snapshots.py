"""Named map snapshots: one for each name, in bounded memory, dropped with their session."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mapper.grid import GridGeometry
from server.downloads import CompressedImage, MapSnapshot, MapSnapshots
from server.downloads.map_snapshots import MAX_KEPT, MAX_KEPT_BYTES, MAX_NAMES


@dataclass
class Session:
    id: str
    closed: bool = False
    on_close: list[Callable[[], None]] = field(default_factory=list)


def make(folder: Path, nbytes: int = 10) -> Callable[[], asyncio.Future[MapSnapshot]]:
    """A maker of snapshots whose images say that they have so many bytes."""
    image = CompressedImage((1, 1), [np.zeros((1, 1), np.uint8)], folder, lambda: None)
    image.nbytes = nbytes

    async def made() -> MapSnapshot:
        await asyncio.sleep(0)
        return MapSnapshot("stem", GridGeometry(0.1, 1, 1), image)

    return lambda: asyncio.ensure_future(made())


async def test_concurrent_requests_with_one_name_get_one_map(tmp_path: Path) -> None:
    snapshots, session = MapSnapshots(), Session("a")
    first, second = await asyncio.gather(*(snapshots.get(session, "x", make(tmp_path)) for _ in range(2)))
    assert first is second
    assert await snapshots.get(session, "x", make(tmp_path)) is first
    assert await snapshots.get(session, "y", make(tmp_path)) is not first
    assert await snapshots.get(Session("b"), "x", make(tmp_path)) is not first


async def test_a_session_keeps_few_images_and_the_geometry_of_older_ones(tmp_path: Path) -> None:
    snapshots, session = MapSnapshots(), Session("a")
    for number in range(MAX_KEPT + 1):
        await snapshots.get(session, f"n{number}", make(tmp_path))
    oldest = await snapshots.get(session, "n0", make(tmp_path))
    assert oldest.image is None, "it is gone, and no other map takes its name"
    assert oldest.geometry == GridGeometry(0.1, 1, 1)
    assert all([(await snapshots.get(session, f"n{n}", make(tmp_path))).image for n in range(1, MAX_KEPT + 1)])
    for number in range(2 * MAX_NAMES):
        await snapshots.get(session, f"m{number}", make(tmp_path))
    assert len(snapshots._sessions["a"]) == MAX_NAMES


async def test_the_session_with_most_bytes_loses_its_images_first(tmp_path: Path) -> None:
    snapshots, modest, greedy = MapSnapshots(), Session("modest"), Session("greedy")
    small = await snapshots.get(modest, "x", make(tmp_path))
    for number in range(3):
        await snapshots.get(greedy, f"n{number}", make(tmp_path, MAX_KEPT_BYTES // 2))
    assert snapshots.nbytes <= MAX_KEPT_BYTES
    assert await snapshots.get(modest, "x", make(tmp_path)) is small
    assert small.image is not None
    assert (await snapshots.get(greedy, "n0", make(tmp_path))).image is None


async def test_a_failed_snapshot_can_be_requested_again_and_a_closed_session_keeps_none(
    tmp_path: Path,
) -> None:
    snapshots, session = MapSnapshots(), Session("a")

    async def fail() -> MapSnapshot:
        raise ValueError

    result = await asyncio.gather(snapshots.get(session, "x", fail), return_exceptions=True)
    assert isinstance(result[0], ValueError)
    assert (await snapshots.get(session, "x", make(tmp_path))).image is not None
    for callback in session.on_close:
        callback()
    assert snapshots.nbytes == 0
    assert snapshots._sessions == {}
