"""The model of a session that plays recorded costmaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from mapper.costmap import NO_INFORMATION
from mapper.io.logs.summary import start_s
from server.sessions.model import NO_READINGS, Footprint, SessionModel
from server.sessions.parts import Costed, Viewed
from server.sessions.tick import TickResult
from server.sessions.view import LogView, Playback
from server.stream.commands import RestartCommand, SeekCommand, StepCommand, TrajectoryCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import LogInfo, TrajectoryInfo
from server.stream.messages import FrameMessage, Hello, ScanFields, Trajectory
from server.stream.protocol import ProtocolError

if TYPE_CHECKING:
    from mapper.core.array_types import Int8Array
    from mapper.io.costmaps import CostmapStream, RecordedCostmap

LOWEST, HIGHEST = 0.0, 254.0  #: of a cell's cost: 254 steps, so that each cost is one byte value


class CostmapsModel(SessionModel, Costed, Viewed):
    """The costmaps of a recording: those of one topic, one after the other."""

    kind: ClassVar[str] = "costmaps"
    replacing: ClassVar[tuple[type[Struct], ...]] = (SeekCommand, RestartCommand, TrajectoryCommand)

    def __init__(
        self, streams: Mapping[str, CostmapStream], *, log_id: str, title: str, topic: str | None = None, index: int = 1
    ) -> None:
        """Show the costmaps of ``topic``, by default the topic with most of them, starting with number ``index``."""
        self._streams = dict(streams)
        self.log_id, self._title = log_id, title
        self._layer = GridLayer("map", "Costmap", "recorded_costs")
        most = max(self._streams, key=lambda name: len(self._streams[name]))
        super().__init__(Playback(speed=1.0, speeds=(0.1, 100.0)))
        self._choose(most if topic is None else topic)
        self._go_to(index)

    def _choose(self, topic: str) -> None:
        if topic not in self._streams:
            raise ProtocolError("costmaps.topic", f"The recording has no costmaps on {topic!r:.80}.")
        self._topic = topic
        stream = self._streams[topic]
        stamps = np.maximum.accumulate(stream.received_ns)
        self._start_s = start_s(stamps)
        self._times = (stamps - stamps[0]).astype(np.float64) * 1e-9
        self._time, self._index = 0.0, 1
        self._show()

    def _show(self) -> None:
        costmap: RecordedCostmap = self._streams[self._topic][self._index - 1]
        self._now = costmap
        self._layer.set(costmap.geometry, costmap.costs, LOWEST, HIGHEST, costmap.costs == NO_INFORMATION)

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The costmap."""
        return (self._layer,)

    @property
    def title(self) -> str:
        """The title of the recording."""
        return self._title

    @property
    def frame_id(self) -> str | None:
        """The frame of the current costmap."""
        return self._now.frame or None

    @property
    def footprint(self) -> Footprint:
        """Cells of the largest costmap, and the bytes of all as cells."""
        costmaps = [costmap for stream in self._streams.values() for costmap in stream.kept]
        return Footprint(
            max(costmap.geometry.rows * costmap.geometry.cols for costmap in costmaps)
            + sum(len(k.packed) for k in costmaps)
        )

    def view(self) -> LogView:
        """Return the topic and the number of the current costmap."""
        return LogView(trajectory=self._topic, index=self._index)

    @property
    def progress(self) -> tuple[int, int]:
        """Number of the current costmap, and their total number."""
        return (self._index, len(self._times))

    def complete(self, hello: Hello) -> None:
        """Set the recording as a log without scans; its trajectories are the topics."""
        hello.log = LogInfo(
            id=self.log_id,
            topic=self._topic,
            cut=None,
            trajectory=self._topic,
            trajectories=[
                TrajectoryInfo(topic, f"{len(stream)} costmaps, frame {', '.join(stream.frames)}", False, None)
                for topic, stream in self._streams.items()
            ],
            compared=None,
            n_beams=0,
            n_scans=len(self._times),
            duration_s=float(self._times[-1]),
            format="costmaps",
            notes=[],
            start_s=self._start_s,
        )

    def messages(self) -> list[Struct]:
        """Return the recording time of each costmap, with the middle of its window."""
        middles = [
            geometry.cell_to_world(((geometry.rows - 1) / 2, (geometry.cols - 1) / 2)).round(3).tolist()
            for geometry in self._streams[self._topic].geometries
        ]
        return [
            Trajectory(
                name=self._topic,
                frame=next(iter(self._streams[self._topic].frames), None),
                every=1,
                poses=middles,
                stamps=np.round(self._times, 3).tolist(),
            )
        ]

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the time of the current costmap."""
        frame.stamp = round(float(self._times[self._index - 1]), 3)

    def scan(self) -> ScanFields:
        """Return a scan without readings."""
        return NO_READINGS

    def present_costs(self) -> RecordedCostmap:
        """Return the current costmap."""
        return self._now

    def present_footprint(self) -> None:
        """Return None, because recorded messages do not contain the footprint."""

    def present_masks(self) -> dict[str, Int8Array]:
        """Return an empty dict, because nothing is painted in a recording."""
        return {}

    # -- computing ------------------------------------------------------------------------------------------------

    def advance(self, dt: float, result: TickResult) -> None:
        """Play."""
        if dt <= 0.0 or not self.playback.playing:
            return
        self._time = min(self._time + dt * self.playback.speed, float(self._times[-1]))
        index = int(np.searchsorted(self._times, self._time, side="right"))
        if index != self._index:
            self._index = index
            self._show()
        result.changed = True
        if index == len(self._times):
            self.playback.playing = False

    def play(self) -> None:
        """Play; from the start if the end was reached."""
        if self._index == len(self._times):
            self._go_to(1)
        super().play()

    def _go_to(self, index: int) -> None:
        self._index = min(max(index, 1), len(self._times))
        self._time = float(self._times[self._index - 1])
        self._show()

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command: seek, step, restart, or another topic (``trajectory``)."""
        count = len(self._times)
        before = (self._topic, self._index, self.playback.playing)
        match command:
            case SeekCommand(index=index):
                if not 0 <= index <= count:
                    raise ProtocolError("command.index", f"There are {count} costmaps; there is none after {index}.")
                self._go_to(index)
            case StepCommand(scans=scans):
                self.playback.playing = False
                self._go_to(self._index + scans)
            case RestartCommand():
                self._go_to(1)
                self.playback.playing = True
            case TrajectoryCommand(name=name):
                self._choose(name)
                result.is_new_hello = True
                result.slot(self.messages()[0])
            case _:
                super().handle(command, result)
                return
        result.changed |= before != (self._topic, self._index, self.playback.playing)
