"""The picture that pages show before the server answers is what a new session with its seed sends first.

``python -m tests.server.test_first_picture --write`` records it again, after a change of the first world, of its robot
or of the protocol.
"""

from __future__ import annotations

import asyncio
import base64
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import zstandard

from tests.server.service import PATIENCE_S, Service, running, settings_for
from tests.server.stream.frame_decoding import decode_frame

FILE = Path(__file__).parents[2] / "static" / "src" / "store" / "firstPicture.json"
SEED = 4  #: of the robot's noise and of its choices: from here it sees the corridor and several rooms
TEXTS = ("layers", "world", "geometry", "frame")


def recorded(service: Service, seed: int) -> dict[str, Any]:
    """Return what a new session with ``seed`` sends until its map is complete."""
    session = service.begin(kind="simulation", seed=seed, playing=False)

    async def read() -> dict[str, Any]:
        texts: list[dict[str, Any]] = []
        async with asyncio.timeout(PATIENCE_S), service.connect(session) as stream:
            while True:
                message = await stream.recv()
                if isinstance(message, bytes):
                    return {"messages": texts, "tiles": base64.b64encode(message).decode()}
                decoded = json.loads(message)
                if decoded["type"] in TEXTS:
                    texts.append(decoded | ({"t": 0.0} if decoded["type"] == "frame" else {}))

    return {"seed": seed, **asyncio.run(read())}


def cells(picture: dict[str, Any]) -> dict[tuple[int, int], np.ndarray[Any, Any]]:
    """Return the tiles of a picture by their place."""
    frame = decode_frame(base64.b64decode(picture["tiles"]))
    return {(tile.tx, tile.ty): np.frombuffer(zstandard.decompress(tile.data), np.int8) for tile in frame.content}


def test_a_new_session_begins_with_the_picture_that_the_pages_show(service: Service) -> None:
    shown = json.loads(FILE.read_text())
    sent = recorded(service, shown["seed"])
    for ours, theirs in zip(shown["messages"], sent["messages"], strict=True):
        assert ours["type"] == theirs["type"]
        if ours["type"] == "frame":
            # Another processor may round a range differently.
            assert np.allclose(ours["pose"], theirs["pose"], atol=0.01)
            before, now = (np.array(one["ranges"], dtype=float) for one in (ours, theirs))  # null is no return
            assert np.allclose(before, now, atol=0.01, equal_nan=True)
        else:
            assert {**ours, "epoch": 0} == {**theirs, "epoch": 0}
    shown_cells, sent_cells = cells(shown), cells(sent)
    assert shown_cells.keys() == sent_cells.keys()
    assert np.mean([np.mean(shown_cells[at] == sent_cells[at]) for at in sent_cells]) > 0.999


if __name__ == "__main__" and "--write" in sys.argv:
    with tempfile.TemporaryDirectory() as folder, running(settings_for(Path(folder))) as begun:
        FILE.write_text(json.dumps(recorded(begun, SEED), separators=(",", ":")) + "\n")
