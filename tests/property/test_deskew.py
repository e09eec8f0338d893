"""Unusual times of beams and scans: the map stays finite, and provenance agrees with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import provenance
from mapper.sensors.scan import ScanLog, Trajectory

STAMPS = st.sampled_from([0, 1, 10**8, 2 * 10**8, 10**9, 2**62, -(2**62)]) | st.integers(-(2**62), 2**62)
INCREMENTS = st.sampled_from([0.0, 1e-3, -1e-3, 1e-308, 3600.0, 1e308, -1e300])


@pytest.mark.filterwarnings("error")
@given(
    st.lists(STAMPS, min_size=1, max_size=8),
    st.integers(1, 6),
    INCREMENTS,
    st.sampled_from(["auto", "on"]),
    st.sampled_from([0.0, 0.1, -2.0]),
    st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_any_times(
    stamps: list[int], n_beams: int, time_increment: float, deskew: str, time_offset: float, seed: int
) -> None:
    random = np.random.default_rng(seed)
    n = len(stamps)
    log = ScanLog(
        random.uniform(0, 9, (n, n_beams)).astype(np.float32),
        -1.0,
        0.1,
        0.05,
        8.0,
        np.array(stamps, dtype=np.int64),
        {"walk": Trajectory(random.normal(0, 3, (n, 3)))},
        time_increment=time_increment,
    )
    config = MappingConfig(deskew=deskew, time_offset=time_offset, resolution=0.2)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    assert np.isfinite(grid.log_odds).all()
    for row, col in np.argwhere(grid.observed)[:3].tolist():
        assert provenance(grid.geometry, log, config, (row, col)).after == grid.log_odds[row, col]
