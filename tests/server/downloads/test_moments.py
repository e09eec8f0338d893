"""Maps of named instants: one for each name, kept in bounded memory, gone with their session."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mapper.grid import GridGeometry
from server.downloads import Moment, Moments, Snapshot
from server.downloads.moments import MAX_KEPT, MAX_KEPT_BYTES, MAX_NAMES


@dataclass
class Session:
    id: str
    closed: bool = False
    on_close: list[Callable[[], None]] = field(default_factory=list)


def make(folder: Path, nbytes: int = 10) -> Callable[[], asyncio.Future[Moment]]:
    """A maker of moments whose images say that they have so many bytes."""
    image = Snapshot((1, 1), [np.zeros((1, 1), np.uint8)], folder, lambda: None)
    image.nbytes = nbytes

    async def made() -> Moment:
        await asyncio.sleep(0)
        return Moment("stem", GridGeometry(0.1, 1, 1), image)

    return lambda: asyncio.ensure_future(made())


async def test_one_name_is_one_map_also_for_those_who_ask_at_the_same_time(tmp_path: Path) -> None:
    moments, session = Moments(), Session("a")
    first, second = await asyncio.gather(*(moments.get(session, "x", make(tmp_path)) for _ in range(2)))
    assert first is second
    assert await moments.get(session, "x", make(tmp_path)) is first
    assert await moments.get(session, "y", make(tmp_path)) is not first
    assert await moments.get(Session("b"), "x", make(tmp_path)) is not first


async def test_a_session_keeps_a_few_images_and_of_older_ones_the_geometry(tmp_path: Path) -> None:
    moments, session = Moments(), Session("a")
    for number in range(MAX_KEPT + 1):
        await moments.get(session, f"n{number}", make(tmp_path))
    oldest = await moments.get(session, "n0", make(tmp_path))
    assert oldest.image is None, "it is gone, and no other map takes its name"
    assert oldest.geometry == GridGeometry(0.1, 1, 1)
    assert all([(await moments.get(session, f"n{n}", make(tmp_path))).image for n in range(1, MAX_KEPT + 1)])
    for number in range(2 * MAX_NAMES):
        await moments.get(session, f"m{number}", make(tmp_path))
    assert len(moments._sessions["a"]) == MAX_NAMES


async def test_who_keeps_most_loses_first(tmp_path: Path) -> None:
    moments, modest, greedy = Moments(), Session("modest"), Session("greedy")
    small = await moments.get(modest, "x", make(tmp_path))
    for number in range(3):
        await moments.get(greedy, f"n{number}", make(tmp_path, MAX_KEPT_BYTES // 2))
    assert moments.nbytes <= MAX_KEPT_BYTES
    assert await moments.get(modest, "x", make(tmp_path)) is small
    assert small.image is not None
    assert (await moments.get(greedy, "n0", make(tmp_path))).image is None


async def test_a_map_that_could_not_be_made_can_be_asked_for_again_and_a_closed_session_keeps_none(
    tmp_path: Path,
) -> None:
    moments, session = Moments(), Session("a")

    async def fail() -> Moment:
        raise ValueError

    result = await asyncio.gather(moments.get(session, "x", fail), return_exceptions=True)
    assert isinstance(result[0], ValueError)
    assert (await moments.get(session, "x", make(tmp_path))).image is not None
    for callback in session.on_close:
        callback()
    assert moments.nbytes == 0
    assert moments._sessions == {}
