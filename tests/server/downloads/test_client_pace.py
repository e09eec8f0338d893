"""How slow the client of a download may be."""

from __future__ import annotations

import asyncio
import itertools
from pathlib import Path
from typing import Any

import pytest

from server.downloads import Content, Download, Downloads
from server.downloads.download_slots import requester
from server.downloads.response import LEAST_BYTES_PER_S, PIECE_BYTES, STALLED_S, ClientPace

KIB = 1 << 10


def taken(bytes_per_s: float, pieces: int, nbytes: int = PIECE_BYTES) -> int:
    """Return how many of the pieces a client at this rate gets."""
    pace = ClientPace()
    for number in range(pieces):
        seconds = nbytes / bytes_per_s
        if seconds > pace.seconds_left:
            return number
        pace.accept(nbytes, seconds)
    return pieces


@pytest.mark.parametrize("rate", [64 * KIB, 40 * KIB, LEAST_BYTES_PER_S])
def test_an_honest_client_on_a_slow_link_gets_everything(rate: int) -> None:
    assert taken(rate, 40_000) == 40_000  # 10 GiB


def test_a_piece_every_29_seconds_is_ended_within_a_minute() -> None:
    assert taken(PIECE_BYTES / 29.0, 40_000) * 29.0 <= 60.0
    assert taken(1.0, 10, nbytes=1) <= STALLED_S


def test_a_client_that_stops_once_for_a_while_goes_on() -> None:
    pace = ClientPace()
    for seconds in (*[4.0] * 20, 29.0, *[4.0] * 20):  # 64 KiB/s, but for one piece
        assert seconds < pace.seconds_left
        pace.accept(PIECE_BYTES, seconds)
    # What was fast before is not counted for ever as a right to stall: no piece has more than this.
    assert pace.seconds_left == STALLED_S


async def test_an_endless_download_by_a_client_that_accepts_each_piece_in_time_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.downloads.response.STALLED_S", 0.3)
    monkeypatch.setattr("server.downloads.response.LEAST_BYTES_PER_S", 1 << 40)
    downloads, sent = Downloads(tmp_path), []

    async def make() -> Content:
        return Content("map.pgm", itertools.repeat(bytes(PIECE_BYTES)))

    async def receive() -> Any:
        await asyncio.Event().wait()

    async def send(message: Any) -> None:
        sent.append(message)
        await asyncio.sleep(0.01)

    await Download(downloads, requester("ann", None, None), make, "image/x-portable-graymap")({}, receive, send)
    await downloads.close()
    assert downloads.slots.taken == 0
    assert all(message.get("more_body", True) for message in sent), (
        "its end was not said: the client sees that it lacks"
    )
