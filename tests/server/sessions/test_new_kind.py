"""A kind of session that is added in one file: its layers, its commands and its 3D drawing reach a client.

``python -m tests.server.sessions.test_new_kind`` writes what such a session sends into the file with which the pages'
side is tested.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from numpy.typing import NDArray

from server.sessions.computation import publish_frame
from server.sources import KINDS
from server.stream.hub import Hub
from tests.server.scenes.viser_client import viser_client
from tests.server.service import Service, running, settings_for
from tests.server.sessions.waves_kind import AMPLITUDE, GEOMETRY, STEP_S, WAVES, WavesModel
from tests.server.stream.frame_decoding import decode_frame

RECORDED = Path(__file__).parents[3] / "static" / "src" / "tools" / "example" / "waves.vectors.json"


@pytest.fixture(scope="module")
def waves(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one kind more."""
    with running(settings_for(tmp_path_factory.mktemp("waves")), {**KINDS, "waves": WAVES}) as service:
        yield service


class Page:
    """Reads a stream of two layers, by what docs/wire.md says."""

    def __init__(self, socket: Any) -> None:
        self.socket = socket
        self.newest: dict[str, dict[str, Any]] = {}
        self.grid: NDArray[np.int8] = np.full(GEOMETRY.shape, -128, dtype=np.int8)
        self.floats: NDArray[np.float32] = np.empty((3, 0), dtype=np.float32)
        self.at = {"height": -1.0, "floats": -1.0}  #: stamp of the frame with which each layer came last

    async def send(self, **command: Any) -> None:
        await self.socket.send(json.dumps(command))

    async def read(self) -> None:
        data = await self.socket.recv()
        if isinstance(data, str):
            message = json.loads(data)
            self.newest[message["type"]] = message
            return
        kind, _, layer, _, seq, count = struct.unpack_from("<BBHIII", data)
        names = {one["id"]: one["name"] for one in self.newest["layers"]["layers"]}
        if kind == 1 and count:
            self._tiles(data, count)
        elif kind == 2:
            columns, _ = struct.unpack_from("<HH", data, 16)
            self.floats = np.frombuffer(data, dtype="<f4", offset=20).reshape(columns, count)
        if count:
            self.at[names[layer]] = self.newest["frame"]["stamp"]
        await self.send(type="ack", seq=seq)

    def _tiles(self, data: bytes, count: int) -> None:
        at = 16
        for _ in range(count):
            tx, ty, _, nbytes = struct.unpack_from("<hhII", data, at)
            raw = zstandard.ZstdDecompressor().decompress(data[at + 12 : at + 12 + nbytes])
            tile = np.frombuffer(raw, dtype=np.int8).reshape(64, 64)
            into = self.grid[ty * 64 : ty * 64 + 64, tx * 64 : tx * 64 + 64]
            into[:] = tile[: into.shape[0], : into.shape[1]]
            at += 12 + nbytes

    def heights(self) -> NDArray[np.float64]:
        """The grid's values, by the geometry message."""
        low, high = self.newest["geometry"]["low"], self.newest["geometry"]["high"]
        return np.asarray(low + (self.grid.astype(np.float64) + 127.0) / 254.0 * (high - low))


async def test_its_layers_reach_a_page_over_one_socket(waves: Service) -> None:
    session_id = waves.begin(kind="waves", wavelength=4.0, playing=False)
    async with waves.connect(session_id) as socket:
        page = Page(socket)
        await page.send(type="subscribe", layers=["height", "floats"])
        await page.send(type="step", scans=13)
        while min(page.at.values()) < 13 * STEP_S - 1e-9:
            await page.read()
        hello = page.newest["hello"]
        assert (hello["kind"], hello["parameters"], hello["log"]) == ("waves", {"table": [], "values": {}}, None)
        assert [(one["name"], one["kind"], one["style"]) for one in page.newest["layers"]["layers"]] == [
            ("height", "grid", "height"),
            ("floats", "points", "floats"),
        ]
        x = GEOMETRY.resolution * (np.arange(GEOMETRY.cols) + 0.5)
        expected = AMPLITUDE * np.sin(2.0 * np.pi * (x / 4.0 - 1.3))
        # A byte is half a step of 1 / 254 of the range from the true value at most.
        np.testing.assert_allclose(page.heights(), np.tile(expected, (GEOMETRY.rows, 1)), atol=AMPLITUDE / 254 + 1e-6)
        x, y, value = page.floats
        np.testing.assert_allclose(value, AMPLITUDE * np.sin(2.0 * np.pi * (x / 4.0 - 1.3)), atol=1e-6)
        assert (len(x), set(y.tolist())) == (15, {10.0})


async def test_time_passes_and_commands_of_other_kinds_are_refused(waves: Service) -> None:
    session_id = waves.begin(kind="waves")
    async with waves.connect(session_id) as socket:
        page = Page(socket)
        while page.newest.get("frame", {"stamp": 0.0})["stamp"] < 0.2:
            await page.read()
        await page.send(type="teleport", x=1.0, y=1.0)
        while "error" not in page.newest:
            await page.read()
        assert page.newest["error"]["code"] == "command.unknown"
        await page.send(type="step", scans=101)
        while page.newest["error"]["code"] != "command.scans":
            await page.read()


async def test_its_surface_is_drawn_in_3d(waves: Service) -> None:
    session_id = waves.begin(kind="waves", wavelength=4.0, playing=False)
    async with viser_client(waves.port, session_id) as client:
        mesh = await client.until(lambda m: m["type"] == "MeshMessage")
        vertices = np.asarray(mesh["props"]["vertices"]).reshape(-1, 3)
        np.testing.assert_allclose(vertices[:, 2], AMPLITUDE * np.sin(2.0 * np.pi * vertices[:, 0] / 4.0), atol=1e-6)
        assert len(vertices) == 20 * 30


def sent() -> list[dict[str, str]]:
    """Messages of both layers of a session with a wavelength of 4 m at its start: texts, and binary frames as hex."""
    model = WavesModel(4.0)
    hub = Hub(model.layers, clock=lambda: 0.0)
    client = hub.join()
    client.subscribe([layer.name for layer in model.layers])
    model.playback.playing = False
    publish_frame(model, hub, watched=True)
    return [{"text": one} if isinstance(one, str) else {"hex": one.hex()} for one in client.take()]


def content(messages: list[dict[str, str]]) -> list[Any]:
    """The messages without epochs, which count all grids of the process, and with the tiles unpacked: how well they
    are packed may change with the library.
    """

    def unpacked(frame: bytes) -> Any:
        kind, body = frame[0], decode_frame(frame).content
        if kind != 1:
            return frame
        return [(one.tx, one.ty, one.revision, zstandard.ZstdDecompressor().decompress(one.data)) for one in body]

    return [
        {key: value for key, value in json.loads(one["text"]).items() if key != "epoch"}
        if "text" in one
        else unpacked(bytes.fromhex(one["hex"]))
        for one in messages
    ]


def test_the_vectors_of_the_pages_are_current() -> None:
    assert content(json.loads(RECORDED.read_text(encoding="utf-8"))) == content(sent())


if __name__ == "__main__":
    RECORDED.write_text(json.dumps(sent(), indent=1) + "\n", encoding="utf-8")
