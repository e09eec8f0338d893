"""Deskewing: each beam is placed at the sensor's pose at the time of the beam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.core.se2 import compose
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_parts
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.mapping.provenance import provenance
from mapper.mapping.scan_batch import bearings, deskewed_scans, placed_scan, sensor_poses_of_readings
from mapper.mapping.update_plan import plan_update
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from tests.mapper.mapping.sweeping import BEAMS, RATE, STEP, off_the_walls, swept, to_the_walls, true_poses


def made(log: ScanLog, **parameters: object) -> OccupancyGrid:
    """The map of all scans but the last, during whose sweep no pose is known."""
    config = MappingConfig().with_values(parameters)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config, stop=log.n_scans - 1)
    return grid


def test_a_robot_that_turns_fast_gets_a_sharp_map_with_deskewing_and_a_smeared_one_without() -> None:
    sharp, smeared = made(swept()), made(swept(), deskew="off")
    assert np.quantile(off_the_walls(sharp), 0.99) < 0.05
    assert np.median(off_the_walls(smeared)) > 0.1
    assert len(off_the_walls(sharp)) < 0.8 * len(off_the_walls(smeared)), "walls are thin"


@pytest.mark.parametrize("model", [model for model in MODELS if model != "moravec_elfes"])
def test_every_model_with_thin_or_wide_beams_is_sharper(model: str) -> None:
    log = swept(15)
    sharp, smeared = (made(log, model=model, opening=0.02, deskew=how) for how in ("auto", "off"))
    assert np.mean(off_the_walls(sharp)) < 0.7 * np.mean(off_the_walls(smeared))


def test_each_beam_has_the_true_pose_of_its_time() -> None:
    log = swept()
    plan = plan_update(MappingConfig(), log.range_min, log.range_max)
    scans, beams = np.divmod(np.arange((log.n_scans - 1) * BEAMS), BEAMS)
    poses = sensor_poses_of_readings(log, plan, None, scans, beams)
    expected = true_poses(100.0 + scans / RATE + beams * STEP)
    np.testing.assert_allclose(poses[..., :2], expected[..., :2], atol=0.02)  # the chord of a bent path
    np.testing.assert_allclose(np.exp(1j * poses[..., 2]), np.exp(1j * expected[..., 2]), atol=0.005)


@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("time_offset", [0.0, 0.05])
def test_a_scan_is_shown_where_it_lies_in_the_map(time_offset: float, upside_down: bool) -> None:
    log = replace(swept(12), mount=(0.2, -0.1, 0.4), upside_down=upside_down)
    config = MappingConfig(time_offset=time_offset, mount_x=0.1, mount_yaw=0.3, mount_upside_down=upside_down)
    plan = plan_update(config, log.range_min, log.range_max)
    beams = np.arange(BEAMS)
    poses = sensor_poses_of_readings(log, plan, None, np.full(BEAMS, 5), beams)
    turned = poses[:, 2] + bearings(log, plan)
    expected = poses[:, :2] + log.ranges[5][:, np.newaxis] * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    placed = placed_scan(log, config, None, 5)
    here = compose(placed.sensor_pose, np.array(config.mount))  # as the page corrects the mount
    angles = here[2] + (-placed.scan.angles if upside_down else placed.scan.angles)
    shown = here[:2] + placed.scan.ranges[:, np.newaxis] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    np.testing.assert_allclose(shown, expected, atol=1e-5)
    np.testing.assert_allclose(compose(placed.base_pose, np.array(log.mount)), placed.sensor_pose)
    unswept = placed_scan(log, replace(config, deskew="off"), None, 5)
    np.testing.assert_array_equal(unswept.scan.ranges, log.ranges[5])


def test_poses_between_the_scans_say_how_a_robot_turned_meanwhile() -> None:
    """A robot that turns to and fro between two scans: the poses at the scans alone say that it stood still."""
    log = swept(20)
    dense = 100.0 + np.arange(-20, 420) * 0.005
    timed = TimedPoses(np.round(dense * 1e9).astype(np.int64), true_poses(dense))
    known = replace(log.trajectory(), timed=timed)
    sparse = swept(20, rate=1.0)  # its scans are a second apart: too far to deskew by them
    assert not deskewed_scans(sparse, plan_update(MappingConfig(), 0.05, 20.0), None).any()
    helped = replace(sparse, trajectories={"true": replace(sparse.trajectory(), timed=timed)})
    assert deskewed_scans(helped, plan_update(MappingConfig(), 0.05, 20.0), None)[:2].all()
    plan = plan_update(MappingConfig(), log.range_min, log.range_max)
    scans, beams = np.divmod(np.arange(10 * BEAMS), BEAMS)
    expected = true_poses(100.0 + scans / RATE + beams * STEP)
    errors = [
        np.abs(sensor_poses_of_readings(one, plan, None, scans, beams)[:, :2] - expected[:, :2]).max()
        for one in (replace(log, trajectories={"true": known}), log)
    ]
    assert errors[0] < 1e-3 < errors[1]


@pytest.mark.parametrize(
    "log",
    [
        pytest.param(swept(20, rate=1.0), id="poses too far apart"),
        pytest.param(replace(swept(20), time_increment=0.0), id="no times of beams"),
        pytest.param(replace(swept(20), stamps_ns=np.zeros(20, np.int64)), id="no times of scans"),
        pytest.param(
            replace(swept(20), trajectories={"still": Trajectory(np.zeros((20, 3)), is_placeholder=True)}),
            id="no poses",
        ),
    ],
)
def test_auto_does_not_deskew_without_close_poses(log: ScanLog) -> None:
    plan = plan_update(MappingConfig(), log.range_min, log.range_max)
    scans, beams = np.divmod(np.arange(20 * BEAMS), BEAMS)
    poses = sensor_poses_of_readings(log, plan, None, scans, beams)
    own = log.trajectory().poses[scans]
    np.testing.assert_allclose(poses[:, :2], own[:, :2])
    np.testing.assert_allclose(np.exp(1j * poses[:, 2]), np.exp(1j * own[:, 2]))


def test_on_deskews_with_poses_a_second_apart() -> None:
    log = swept(4, rate=1.0)
    plan = plan_update(MappingConfig(deskew="on"), log.range_min, log.range_max)
    last = sensor_poses_of_readings(log, plan, None, np.array([1]), np.array([BEAMS - 1]))
    share = STEP * (BEAMS - 1)  # of the second to the next pose
    first, second = log.trajectory().poses[1:3]
    np.testing.assert_allclose(last[0, :2], (first + share * (second - first))[:2])


@pytest.mark.parametrize("values", [{"update": "per_scan"}, {"model": "moravec_elfes"}])
def test_per_scan_updates_use_one_pose_per_scan(values: dict[str, str]) -> None:
    log = swept(3)
    on, off = (made(log, **values, deskew=how, resolution=0.2) for how in ("on", "off"))
    np.testing.assert_array_equal(on.log_odds, off.log_odds)


def test_the_map_is_the_same_in_parts_and_on_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    log = swept(12)
    config = MappingConfig()
    whole = made(log)
    in_parts = OccupancyGrid(geometry_for(log, config))
    for _ in integrate_parts(in_parts, log, config, None, 0, log.n_scans - 1):
        pass
    np.testing.assert_array_equal(in_parts.log_odds, whole.log_odds)
    for threads in (1, 3):
        monkeypatch.setattr("mapper.mapping.update.cores", lambda threads=threads: threads)
        np.testing.assert_array_equal(made(log).log_odds, whole.log_odds)


def test_why_agrees_with_the_map() -> None:
    log, config = swept(12), MappingConfig()
    grid = made(log)
    rows, cols = np.nonzero(grid.observed)
    for at in np.linspace(0, len(rows) - 1, 40).astype(int):
        told = provenance(grid.geometry, log, config, (rows[at], cols[at]), stop=log.n_scans - 1)
        assert told.after == grid.log_odds[rows[at], cols[at]]
        np.testing.assert_array_equal(told.ranges, log.ranges[told.scans, told.beams])


def test_a_clock_that_is_late_is_put_right_by_the_time_offset() -> None:
    late = swept(delay=0.3)
    wrong, right = made(late), made(late, time_offset=0.3)
    assert np.median(off_the_walls(wrong)) > 0.1
    assert np.quantile(off_the_walls(right), 0.8) < 0.05


def test_a_time_offset_moves_scans_of_one_time_each_too() -> None:
    late = replace(swept(delay=0.3), time_increment=0.0)
    still = replace(late, ranges=to_the_walls(
        np.array([[[x, y, yaw + 2 * np.pi / BEAMS * k - np.pi] for k in range(BEAMS)]
                  for x, y, yaw in true_poses(100.0 + np.arange(40) / RATE)])
    ).astype(np.float32))  # fmt: skip
    assert np.median(off_the_walls(made(still))) > 0.1
    assert np.quantile(off_the_walls(made(still, time_offset=0.3)), 0.8) < 0.05
