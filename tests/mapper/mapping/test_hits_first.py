"""In the cells that a scan hits, only the hits count: a wall at a grazing angle, by hand and as a lidar sees it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose
from mapper.grid import OCCUPIED_THRESHOLD, GridGeometry, OccupancyGrid
from mapper.mapping import textbook, textbook_deskew
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_scan
from mapper.mapping.parameters import HIT_OR_PASSED, MODELS, MappingConfig
from mapper.mapping.provenance import provenance
from mapper.sensors.scan import ScanLog, Trajectory
from tests.mapper.mapping.sweeping import HALF, swept, to_the_walls

#: Cells of 1 m, the sensor on the centre of the cell (0, 0), and a wall that fills row 1. Bresenham's lines to the
#: wall's cells in columns 4, 3 and 2 are (0,0) (0,1) (1,2) (1,3) (1,4); (0,0) (0,1) (1,2) (1,3); (0,0) (1,1) (1,2).
HERE = (0.5, 0.5, 0.0)
ENDS = np.array([[4.0, 1.0], [3.0, 1.0], [2.0, 1.0]])
PASSED, HIT = {"both_count": -0.4, "only_hits": 0.0}, 0.85


def grazing(beams: list[int], deskewed: bool = False) -> ScanLog:
    """Two scans of the beams to the cells of the wall: of all ``beams``, then of the first of them alone."""
    angles = np.arctan2(ENDS[beams, 1], ENDS[beams, 0])
    ranges = np.tile(np.hypot(*ENDS[beams].T), (2, 1)).astype(np.float32)
    ranges[1, 1:] = np.nan
    return ScanLog(
        ranges, 0.0, 0.1, 0.0, 80.0, np.array([0, 10**8]), {"still": Trajectory(np.tile(HERE, (2, 1)))},
        bearings=angles, time_increment=1e-3 if deskewed else 0.0,
    )  # fmt: skip


@pytest.mark.parametrize("rule", ["both_count", "only_hits"])
@pytest.mark.parametrize("beams", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
@pytest.mark.parametrize("deskew", ["on", "off"])
def test_a_wall_at_a_grazing_angle_by_hand(rule: str, beams: list[int], deskew: str) -> None:
    config = MappingConfig(resolution=1.0, clamp=False, hit_and_passed=rule, deskew=deskew)
    log = grazing(beams, deskewed=True)
    none = PASSED[rule]
    first = np.array([[-1.2, -0.8, 0, 0, 0], [0, -0.4, HIT + 2 * none, HIT + none, HIT]], np.float32)
    grid = OccupancyGrid(GridGeometry(1.0, 2, 5))
    integrate_log(grid, log, config, stop=1)
    np.testing.assert_allclose(grid.log_odds, first, atol=1e-6)
    live = OccupancyGrid(GridGeometry(1.0, 2, 5))
    change = integrate_scan(live, log.scan(0), HERE, config)
    np.testing.assert_allclose(live.log_odds, first, atol=1e-6)
    assert change.cells_updated == 12, "what counts for nothing is an update by 0"
    # A scan that does not hit the cells speaks against them.
    integrate_log(grid, log, config, start=1)
    end = int(ENDS[beams[0], 0])
    passed = {4: [(0, 0), (0, 1), (1, 2), (1, 3)], 3: [(0, 0), (0, 1), (1, 2)], 2: [(0, 0), (1, 1)]}[end]
    for cell in passed:
        first[cell] += np.float32(-0.4)
    first[1, end] += np.float32(HIT)
    np.testing.assert_allclose(grid.log_odds, first, atol=1e-6)


def test_why_lists_what_counts_for_nothing_after_the_hits_of_its_scan() -> None:
    config = MappingConfig(resolution=1.0, hit_and_passed="only_hits")
    told = provenance(GridGeometry(1.0, 2, 5), grazing([0, 1, 2]), config, (1, 2))
    assert list(zip(told.scans.tolist(), told.beams.tolist(), strict=True)) == [(0, 2), (0, 0), (0, 1), (1, 0)]
    assert told.hits.tolist() == [True, False, False, False]
    assert told.outweighed.tolist() == [False, True, True, False]
    np.testing.assert_allclose(told.increments, [HIT, 0.0, 0.0, -0.4], atol=1e-6)
    np.testing.assert_allclose(told.log_odds, [HIT, HIT, HIT, HIT - 0.4], atol=1e-6)
    assert not provenance(
        GridGeometry(1.0, 2, 5), grazing([0, 1, 2]), MappingConfig(resolution=1.0), (1, 2)
    ).outweighed.any()


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
def test_it_acts_on_thin_beams_with_steps_and_on_nothing_else(model: str, update: str) -> None:
    maps = []
    for rule in ("both_count", "only_hits"):
        config = MappingConfig(model=model, update=update, resolution=1.0, opening=0.1, hit_and_passed=rule)
        grid = OccupancyGrid(GridGeometry(1.0, 2, 5))
        integrate_log(grid, grazing([0, 1, 2]), config)
        maps.append(grid.log_odds)
    acts = model in HIT_OR_PASSED and update == "per_beam"
    assert (maps[0].tobytes() != maps[1].tobytes()) == acts
    assert set(HIT_OR_PASSED) == {"fixed_increments", "step_window"}


@pytest.mark.parametrize("traversal", ["bresenham", "amanatides_woo"])
@pytest.mark.parametrize("window", [0.0, 0.3])
def test_the_scans_of_a_lidar_equal_the_textbook(traversal: str, window: float) -> None:
    log = replace(swept(3), time_increment=0.0)  # coarse cells, so that most that are hit are passed as well
    config = MappingConfig(hit_and_passed="only_hits", traversal=traversal, window=window, resolution=0.25)
    ours, theirs = (OccupancyGrid(geometry_for(log, config)) for _ in range(2))
    count = integrate_log(ours, log, config)
    poses = log.sensor_poses()
    assert count == sum(textbook.occupancy_grid_mapping(theirs, log.scan(t), poses[t], config) for t in range(3))
    np.testing.assert_array_equal(ours.log_odds, theirs.log_odds)
    np.testing.assert_array_equal(ours.observed, theirs.observed)


def test_chunks_do_not_part_the_beams_of_a_deskewed_scan(monkeypatch: pytest.MonkeyPatch) -> None:
    log = swept(4)
    config = MappingConfig(hit_and_passed="only_hits", resolution=0.25, deskew="on")
    geometry = geometry_for(log, config)
    monkeypatch.setattr("mapper.mapping.scan_batch._CHUNK_READINGS", 500)
    ours, theirs = OccupancyGrid(geometry), OccupancyGrid(geometry)
    integrate_log(ours, log, config)
    for t in range(log.n_scans):
        textbook.update_hits_first(theirs, textbook_deskew.deskewed(log, t, config), config)
    np.testing.assert_allclose(ours.log_odds, theirs.log_odds, atol=1e-6)
    for row, col in np.argwhere(ours.observed)[::40].tolist():
        assert provenance(geometry, log, config, (row, col)).after == ours.log_odds[row, col]


def found_of_the_walls(rule: str) -> float:
    """Return the share of the cells of walls, those in which beams end, that are occupied.

    A lidar of 682 beams on 240° drives along a wall of a room, 0.8 m from it; the walls are oblique to the grid.
    """
    angles = np.radians(np.linspace(-120.0, 120.0, 682))
    poses = np.zeros((60, 3))
    poses[:, 0], poses[:, 1] = np.linspace(-3.0, 3.0, 60), 0.8 - HALF[1]
    beams = np.repeat(poses[:, np.newaxis], 682, axis=1)
    beams[..., 2] += angles
    ranges = to_the_walls(beams)
    poses, beams = (compose(np.array([0.0, 0.0, 0.3]), one) for one in (poses, beams))
    log = ScanLog(
        ranges.astype(np.float32), angles[0], angles[1] - angles[0], 0.05, 30.0, np.arange(60) * 10**8,
        {"true": Trajectory(poses)},
    )  # fmt: skip
    config = MappingConfig(hit_and_passed=rule)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    heading = np.stack([np.cos(beams[..., 2]), np.sin(beams[..., 2])], axis=-1)
    ends = grid.geometry.world_to_cell(beams[..., :2] + ranges[..., np.newaxis] * heading).reshape(-1, 2)
    rows, cols = np.unique(ends, axis=0).T
    return float(np.mean(grid.p_occ[rows, cols] > OCCUPIED_THRESHOLD))


def test_a_lidar_of_many_beams_finds_walls_that_it_sees_at_a_grazing_angle() -> None:
    assert found_of_the_walls("only_hits") > 0.95
    assert found_of_the_walls("both_count") < 0.93
