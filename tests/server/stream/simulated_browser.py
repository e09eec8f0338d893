"""A grid with its hub and a browser's end of the protocol, for tests that need no socket."""

from __future__ import annotations

import json
import struct
from collections import Counter
from typing import Any

import numpy as np

from mapper.grid import CellBox, GridGeometry, OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from server.stream.grid_layer import GridLayer, TilePicture
from server.stream.hub import Hub
from server.stream.messages import FrameMessage, ScanFields
from tests.server.stream.applied_frames import apply_frame

ROWS, COLS = 64 * 4, 64 * 5
TICK_S = 1.0 / 30.0


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def frame_message(index: int) -> FrameMessage:
    """The frame message of a robot at the origin."""
    pose = (0.0, 0.0, 0.0)
    return FrameMessage(
        t=0.0, playing=True, speed=1.0, index=index, count=0, stamp=0.0, pose=pose, sensor_pose=pose, auto=False
    )


class Source:
    """A grid that is changed at will, and its hub."""

    def __init__(self, rows: int = ROWS, cols: int = COLS) -> None:
        self.clock = Clock()
        self.config = MappingConfig()  # whose clamp is -2 … 3.5
        self.layer = GridLayer("map", "Map")
        self.begin(rows, cols)
        self.hub = Hub([self.layer], self.clock)

    def begin(self, rows: int, cols: int) -> None:
        self.grid = OccupancyGrid(GridGeometry(0.1, rows, cols))
        self.layer.update(self.grid, self.config, None, whole=True)

    def new_epoch(self, rows: int, cols: int) -> None:
        self.begin(rows, cols)
        self.publish()

    @property
    def epoch(self) -> int:
        return self.layer.epoch

    @property
    def picture(self) -> TilePicture:
        assert self.layer.picture is not None
        return self.layer.picture

    def paint(self, row: int, col: int, value: float) -> None:
        row, col = row % self.grid.geometry.rows, col % self.grid.geometry.cols
        self.grid.log_odds[row, col] = value
        self.grid.observed[row, col] = True
        self.layer.update(self.grid, self.config, CellBox(row, row + 1, col, col + 1), whole=False)

    def fill(self, row: int, col: int, rows: int, cols: int, value: float) -> None:
        box = np.s_[row : row + rows, col : col + cols]
        self.grid.log_odds[box] = value
        self.grid.observed[box] = True
        self.layer.update(self.grid, self.config, CellBox(row, row + rows, col, col + cols), whole=False)

    def publish(self, *, settled: bool = False) -> None:
        number = self.hub.frame_number
        self.hub.publish(frame_message(number), ScanFields(range_max=float(number)), (0.0, 0.0), settled=settled)


class Browser:
    """The other end: applies frames as the protocol says, on its own arithmetic."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.client = source.hub.join()
        self.epoch = 0
        self.cells = np.zeros((0, 0), dtype=np.int8)
        self.seq = 0
        self.kept: tuple[int, int] | None = None  #: (epoch, revision) of the newest complete picture
        self.times: list[float] = []
        self.order: list[tuple[int, int]] = []
        self.kinds: Counter[int] = Counter()

    def read(self) -> int:
        """Take what is sent; return the number of messages."""
        messages = self.client.take()
        for message in messages:
            if isinstance(message, bytes):
                self._apply(message)
            else:
                self._hear(json.loads(message))
        return len(messages)

    def _hear(self, message: dict[str, Any]) -> None:
        if message["type"] == "geometry" and message["epoch"] != self.epoch:
            self.epoch = message["epoch"]
            self.cells = np.full((message["rows"], message["cols"]), -128, dtype=np.int8)
        if message["type"] == "frame":
            self.times.append(message["t"])

    def _apply(self, frame: bytes) -> None:
        kind, flags, layer, epoch, seq, count = struct.unpack_from("<BBHIII", frame)
        assert kind in (1, 4)
        assert layer == 1
        assert seq == self.seq + 1
        assert epoch == self.epoch
        self.seq = seq
        newest, places = apply_frame(frame, self.cells)
        assert len(places) == count
        self.order += places
        self.kinds[kind] += 1
        self.newest = max(getattr(self, "newest", 0), newest)
        if flags & 1:
            self.kept = (epoch, getattr(self, "newest", 0))

    def acknowledge(self) -> None:
        self.client.acknowledge(self.seq)

    def reconnect(self) -> None:
        """Lose the connection, with all that is on its way, and say what was kept."""
        self.source.hub.leave(self.client)
        self.client = self.source.hub.join()
        self.seq = 0
        if self.kept is not None and self.kept[0] == self.epoch:
            self.client.resume("map", *self.kept)
