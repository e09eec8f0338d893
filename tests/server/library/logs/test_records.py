"""Summaries of logs as databases have them."""

from __future__ import annotations

from typing import Any

from mapper.sensors.scan import Topic
from server.library.logs.records import summary_from_json

STORED: dict[str, Any] = {
    "name": "a.bag", "format": "ROS 1 bag", "scans": 3, "beams": 181, "duration_s": 2, "field_of_view_deg": 180.0,
    "angle_min": -1.5, "angle_increment": 0.0175, "range_max": 30.0, "mount": [0.1, 0.0, 0.0],
    "readings": {"measured": 500, "no_return": 40, "invalid": 3}, "trajectories": [], "notes": ["one"],
    "topics": [{"name": "/scan", "type": "LaserScan", "count": 3, "mount": [0.1, 0.0, 0.0], "bytes": 9000}],
}  # fmt: skip


def test_a_stored_summary_is_read_although_its_topics_said_more_once() -> None:
    summary = summary_from_json(STORED)
    assert summary is not None
    assert (summary.duration_s, summary.mount, summary.notes) == (2.0, (0.1, 0.0, 0.0), ("one",))
    assert summary.topics == (Topic("/scan", "LaserScan", 3, mount=(0.1, 0.0, 0.0)),)


def test_a_summary_that_lacks_fields_is_none() -> None:
    for field in ("readings", "mount", "notes"):
        assert summary_from_json({name: value for name, value in STORED.items() if name != field}) is None
    assert summary_from_json(None) is None
