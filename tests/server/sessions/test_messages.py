"""Readings in the frame message."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan
from server.sessions.model import scan_of
from server.sessions.view import RobotState

POSE = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("range_max", [10.1, 1e12])
def test_readings_are_rounded_and_what_is_none_is_null(range_max: float) -> None:
    ranges = [0.05, 0.1, 1.23456, 10.1, 1e11, np.inf, -np.inf, np.nan, 2.0]
    scan = LaserScan(np.array(ranges, dtype=np.float32), 0.0, 0.1, 0.1, range_max)
    fields = scan_of(RobotState(POSE, POSE, POSE, scan, 0.0), MappingConfig())
    sent = msgspec.json.decode(msgspec.json.encode(fields))["ranges"]
    far = None if range_max < 1e11 else round(float(np.float32(1e11)), 3)
    assert sent == [None, 0.1, 1.235, 10.1, far, None, None, None, 2.0]
