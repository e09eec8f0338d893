"""The small picture of a log's map, compared with the room in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.replay import overview
from mapper.replay.overview import FREE, OCCUPIED, PATH, UNOBSERVED, map_overview
from mapper.sensors.scan import ScanLog, Trajectory

HALF_X, HALF_Y = 6.0, 4.0  # of a room whose centre is the origin, metres


def room_log(poses: np.ndarray, *, beams: int = 240, mount: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ScanLog:
    """A log of exact readings in a rectangular room, by its distance to the nearer wall along each beam."""
    increment = 2.0 * np.pi / beams
    bearings = -np.pi + increment * np.arange(beams)
    x, y, yaw = poses.T
    sensor_x = x + np.cos(yaw) * mount[0] - np.sin(yaw) * mount[1]
    sensor_y = y + np.sin(yaw) * mount[0] + np.cos(yaw) * mount[1]
    angle = (yaw + mount[2])[:, None] + bearings
    with np.errstate(divide="ignore"):
        to_x = (np.sign(np.cos(angle)) * HALF_X - sensor_x[:, None]) / np.cos(angle)
        to_y = (np.sign(np.sin(angle)) * HALF_Y - sensor_y[:, None]) / np.sin(angle)
    ranges = np.minimum(to_x, to_y).astype(np.float32)
    stamps = np.arange(len(poses)) * 100_000_000
    return ScanLog(ranges, -np.pi, increment, 0.1, 30.0, stamps, {"way": Trajectory(poses)}, mount=mount)


def along(n: int) -> np.ndarray:
    """Poses on a line from (−3, −1) to (3, 1), turning."""
    share = np.linspace(0.0, 1.0, n)
    return np.column_stack([-3.0 + 6.0 * share, -1.0 + 2.0 * share, 5.0 * share])


@pytest.mark.parametrize("mount", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.7)])
def test_walls_free_space_and_path_of_a_room(mount: tuple[float, float, float]) -> None:
    codes = map_overview(room_log(along(40), mount=mount))
    assert codes is not None
    rows, cols = codes.shape
    cell = max(2.0 * HALF_X / (overview.SIDE - 2 * overview.MARGIN_CELLS), overview.LEAST_CELL_M)
    centre = np.array([cols, rows]) / 2.0
    row, col = np.nonzero(codes == OCCUPIED)
    x, y = (col + 0.5 - centre[0]) * cell, (centre[1] - row - 0.5) * cell
    beside = np.minimum(np.abs(np.abs(x) - HALF_X), np.abs(np.abs(y) - HALF_Y))
    assert len(row) > 400
    assert beside.max() < 2.5 * cell
    assert np.mean(codes == FREE) > 0.6
    assert codes[0, 0] == UNOBSERVED
    # The path rises from the left to the right: row 0 is at the greatest y.
    path_row, path_col = np.nonzero(codes == PATH)
    assert np.corrcoef(path_row, path_col)[0, 1] < -0.99
    assert np.ptp(path_col) * cell == pytest.approx(6.0, abs=3 * cell)


def test_a_long_log_with_many_beams_is_drawn_from_a_part_of_them() -> None:
    few = map_overview(room_log(along(overview.MAX_SCANS), beams=overview.MAX_BEAMS))
    many = map_overview(room_log(along(4000), beams=480))
    assert few is not None
    assert many is not None
    assert max(many.shape) <= overview.SIDE + 2 * overview.MARGIN_CELLS
    assert few.shape == many.shape
    assert np.mean((few == FREE) == (many == FREE)) > 0.97


def test_a_log_without_a_reading_has_no_picture() -> None:
    log = room_log(along(3))
    empty = ScanLog(np.full_like(log.ranges, np.inf), -np.pi, 0.1, 0.1, 30.0, log.stamps_ns, dict(log.trajectories))
    assert map_overview(empty) is None
