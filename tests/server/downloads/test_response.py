"""A download as the messages of its answer."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from server.downloads import Content, Download, Downloads
from server.downloads.download_slots import requester
from server.downloads.response import PIECE_BYTES


async def test_a_file_that_is_made_at_once_is_sent_in_pieces_that_a_slow_client_can_accept_in_time(
    tmp_path: Path,
) -> None:
    data = bytes(range(256)) * (5 * PIECE_BYTES // 512)  # two and a half pieces
    downloads, sent = Downloads(tmp_path), []

    async def make() -> Content:
        return Content("mesh.ply", iter([data]), len(data))

    async def receive() -> Any:
        await asyncio.Event().wait()

    async def send(message: Any) -> None:
        sent.append(message.get("body", b""))

    answer = Download(downloads, requester("ann", None, None), make, "application/octet-stream")
    await answer({"type": "http"}, receive, send)
    await downloads.close()
    assert b"".join(sent) == data
    assert max(map(len, sent)) == PIECE_BYTES
