"""A recording of a real Nav2, played from its first to its last costmap: all cells of all of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from mapper.io.costmaps import open_costmaps
from server.parts.wire import command_of
from server.sessions.tick import TickResult
from server.sources.costmaps import CostmapsModel

TOPIC = "/local_costmap/costmap"


@pytest.mark.data
def test_each_costmap_of_a_recording_is_played_cell_for_cell(data_file: Callable[[str], Path]) -> None:
    path = data_file("bags/cm_moving_obstacle_0.mcap")
    model = CostmapsModel(open_costmaps(path), log_id="recording", title="recording")
    stamps = [one.received_ns for one in open_costmaps(path)[TOPIC]]
    steps = np.diff(np.maximum.accumulate(stamps), prepend=stamps[0]) * 1e-9
    played = 0
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for index, (_, _, _, message) in enumerate(reader.iter_decoded_messages(topics=[TOPIC])):
            if index and steps[index] > 0.0:
                model.playback.playing = True
                model.advance(steps[index] + 1e-9, TickResult())
                assert model.progress[0] >= index + 1
            model.handle(command_of({"type": "seek", "index": index + 1}), TickResult())
            now, meta = model.present_costs(), message.metadata
            assert now.costs.shape == (meta.size_y, meta.size_x)
            assert now.costs.tobytes() == bytes(message.data)
            assert now.geometry.origin[:2] == (meta.origin.position.x, meta.origin.position.y)
            played += 1
    assert model.progress == (played, 231)
    for command, is_change in (("seek", False), ("step", True)):
        result = TickResult()
        model.handle(command_of({"type": command, "index": played, "scans": -1}), result)
        assert result.changed is is_change
