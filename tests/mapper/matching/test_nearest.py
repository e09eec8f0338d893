"""The nearest point of a scan, in its field of view or not, is that of a search through all its points."""

import numpy as np
import pytest

from mapper.matching.beams import prepare_scans
from mapper.matching.kernels.types import POINT
from mapper.matching.kernels.views import _pair_points
from mapper.sensors.scan import ScanLog, Trajectory

GATE = 3.0


@pytest.mark.parametrize("field_of_view", [0.9, 1.2 * np.pi, 1.5 * np.pi, 1.7 * np.pi, 1.98 * np.pi, 2.0 * np.pi])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_no_nearer_point_is_missed_behind_the_sensor(field_of_view: float, direction: float) -> None:
    rng = np.random.default_rng(5)
    n_beams, mount = 40, (0.1, -0.2, 0.7)
    ranges = rng.uniform(0.3, 3.0, (1, n_beams)).astype(np.float32)
    step = direction * field_of_view / n_beams
    log = ScanLog(
        ranges, -0.5 * field_of_view, step, 0.05, 10.0, np.zeros(1, dtype=np.int64),
        {"scan": Trajectory(np.zeros((1, 3)))}, mount,
    )  # fmt: skip
    bearings = mount[2] - 0.5 * field_of_view + step * np.arange(n_beams)
    points = np.array(mount[:2]) + ranges[0, :, None] * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    asked = rng.uniform(-2.0, 2.0, (500, 2))
    distances = np.hypot(*(asked[:, None] - points).transpose(2, 0, 1))
    scans = prepare_scans(log)
    found = np.empty(len(asked), dtype=np.int64)
    _pair_points(scans, 0, asked, len(asked), GATE, n_beams, POINT, found)
    assert (found >= 0).tolist() == (distances.min(axis=1) < GATE).tolist()
    near = found >= 0
    chosen = np.hypot(*(asked[near] - scans.points[0][found[near]]).T)
    np.testing.assert_allclose(chosen, distances[near].min(axis=1), atol=1e-5)
