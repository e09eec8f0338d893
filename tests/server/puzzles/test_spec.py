"""Definitions of visitors' puzzles as databases have them: they are read, and written in the same way."""

from __future__ import annotations

import pytest

from server.puzzles.spec import LogSpec, WorldSpec, spec_from_text, spec_text

OF_A_STORY = (
    '{"kind": "story", "story": {"world": "room", "seed": 2, "sensor": {}, "edits": {"added": [], "erased": []}, '
    '"steps": 150, "journal": [[4, {"type": "drive", "linear": 0.5, "angular": 0.0}], '
    '[5, {"type": "teleport", "x": 6.0, "y": 6.2}], [6, {"type": "teleport", "x": 6.0, "y": 6.0, "yaw": 1.0}], '
    '[7, {"type": "sensor", "values": {"n_beams": 90, "range_max": 7}}], [8, {"type": "auto", "value": false}], '
    '[9, {"type": "edit", "added": [["box", 300, 300, 340, 340]], "erased": []}]], "pose": [1.0, 2.5, 0.125], '
    '"auto": true, "parameters": {"mount_yaw": 0.15}, "faults": {}, "speed": 1.0, "playing": false, '
    '"navigation": [{"type": "costmap", "values": {}, "footprint": [[0.25, 0.0], [0.0, 0.2], [-0.2, 0.0]], '
    '"keepout": [{"width": 0.4, "erases": false, "points": [[9.0, 7.0], [9.5, 7.0]]}, '
    '{"width": 0.4, "erases": false, "points": [[9.0, 7.0]], "speed": 30}]}, {"type": "nav2", "text": "a: 1"}, '
    '{"type": "costmap", "values": {"static_layer": true}}, {"type": "goal", "x": 7.0, "y": 7.0, "drives": false}]}, '
    '"fault": "as-it-is", "cause": "mount_yaw", "seed": 17}'
)
OF_A_LOG = (
    '{"kind": "log", "view": {"topic": "/scan", "trajectory": null, "cut": {"low": 0.2}}, '
    '"values": {"model": "simple", "max_range": 8.0, "clamp": false, "subsample": 2}, '
    '"fault": "beam_order", "cause": "beam_order", "seed": 3}'
)


@pytest.mark.parametrize(("text", "kind"), [(OF_A_STORY, WorldSpec), (OF_A_LOG, LogSpec)])
def test_a_stored_spec_is_read_and_written_the_same(text: str, kind: type) -> None:
    spec = spec_from_text(text)
    assert isinstance(spec, kind)
    assert spec_text(spec) == text
