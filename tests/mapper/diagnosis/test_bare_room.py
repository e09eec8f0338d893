"""Clean straight drives in a bare room: all scans move alike there, so that little tells one error from another."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.diagnosis.examination import examine
from mapper.sensors.scan import ScanLog, Trajectory


def straight(size: tuple[float, float], start: tuple[float, float], end: tuple[float, float], beams: int) -> ScanLog:
    """A drive at constant speed in a rectangle, walls at round coordinates, readings without noise."""
    n = 60
    places = np.linspace(start, end, n)
    yaw = float(np.arctan2(end[1] - start[1], end[0] - start[0]))
    angles = -np.pi + 2.0 * np.pi / beams * np.arange(beams)
    directions = np.stack([np.cos(yaw + angles), np.sin(yaw + angles)], axis=-1)
    with np.errstate(divide="ignore"):
        walls = np.where(directions > 0.0, np.array(size) - places[:, np.newaxis], -places[:, np.newaxis])
        ranges = (np.abs(walls) / np.abs(directions)).min(axis=-1)
    return ScanLog(
        ranges=ranges.astype(np.float32),
        angle_min=-np.pi,
        angle_increment=2.0 * np.pi / beams,
        range_min=0.05,
        range_max=30.0,
        stamps_ns=1_700_000_000_000_000_000 + 100_000_000 * np.arange(n),
        trajectories={"odom": Trajectory(np.column_stack([places, np.full(n, yaw)]), frame_id="odom")},
    )


@pytest.mark.parametrize(
    ("size", "start", "end", "beams"),
    [
        ((6.0, 6.0), (1.0, 1.0), (5.0, 5.0), 181),
        ((10.0, 7.0), (1.5, 3.3), (8.5, 3.9), 360),
        ((12.0, 12.0), (6.0, 1.0), (6.0, 11.0), 90),
        ((80.0, 3.0), (3.0, 1.5), (75.0, 1.5), 90),  # at 12 m/s
        ((80.0, 3.0), (3.0, 1.5), (75.0, 1.5), 360),
    ],
)
def test_nothing_is_found(
    size: tuple[float, float], start: tuple[float, float], end: tuple[float, float], beams: int
) -> None:
    assert examine(straight(size, start, end, beams)) == []
