"""``gridbloom localize``: what it writes, and what it refuses."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.io.export import write_mcap
from mapper.io.maps import save_map
from mapper.io.trajectories import read_tum
from mapper.localization import LocalizationConfig, Localized, amcl_yaml
from mapper.sensors.scan import ScanLog
from server.cli.poses.localize import doubts
from tests.mapper.io.contents.recorded_robot import T0
from tests.mapper.io.logs import recorded
from tests.mapper.localization.rooms import office, two_lidars
from tests.server.cli.poses.test_slam import carmen
from tests.server.cli.running import Run

FEW = ("--set", "global_particles=8000")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, ScanLog]:
    grid, log = office()
    folder = tmp_path_factory.mktemp("localize")
    save_map(grid, folder / "office", "trinary")
    return carmen(folder / "office.log", log), folder / "office.yaml", log


def test_writes_a_pose_for_each_scan_and_how_certain_it_is(run: Run, files, tmp_path: Path):
    log, grid, drive = files
    out = tmp_path / "new" / "poses.tum"
    status, printed, err = run("localize", log, "--map", grid, "--out", out, "--json", "--seed", "1", *FEW)
    assert status == 0, err
    facts = json.loads(printed)
    assert facts["scans"] == drive.n_scans
    assert facts["last_converged"] is True
    poses = read_tum(out).poses
    true = drive.trajectory("true").poses
    assert len(poses) == drive.n_scans
    assert np.hypot(*(poses - true)[-10:, :2].T).max() < 0.4
    with out.with_name("poses.covariance.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert [int(row["scan"]) for row in rows] == list(range(drive.n_scans))
    first = facts["converged_at_scan"]
    assert [row["converged"] for row in rows[: first + 1]] == ["0"] * first + ["1"]
    assert float(rows[0]["xx"]) > 1.0
    assert float(rows[-1]["xx"]) < 0.25
    assert facts["files"] == [str(out), str(out.with_name("poses.covariance.csv"))]


def test_scans_at_which_the_robot_was_not_found_are_left_out(run: Run, files, tmp_path: Path) -> None:
    _, grid, drive = files
    short, out = carmen(tmp_path / "short.log", drive.take(slice(0, 2))), tmp_path / "poses.tum"
    status, printed, err = run("localize", short, "--map", grid, "--out", out, *FEW)
    assert status == 0, err
    assert "never converged: where the robot was is not known" in printed
    assert "left out: 2 scans, at which the filter had not converged" in printed
    assert [path.name for path in tmp_path.glob("poses*")] == ["poses.covariance.csv"]


def test_a_filter_that_was_mostly_uncertain_is_said() -> None:
    poses = np.zeros((10, 3))
    converged = np.isin(np.arange(10), (2, 3, 9))
    flat, whole = np.zeros(10), np.zeros(10, dtype=np.int64)
    localized = Localized(
        poses, np.zeros((10, 3, 3)), converged, flat, flat, whole, flat, converged, "odom", 0.0, converged
    )
    assert "From scan 2 on the filter had converged at 3 of 8 scans only" in str(doubts(localized, 2))
    mostly = replace(localized, is_converged=np.arange(10) >= 2)
    assert doubts(mostly, 2) == []
    never = replace(mostly, is_sure=np.zeros(10, dtype=bool))
    assert "The place is not sure at any scan" in str(doubts(never, 2))


def test_with_a_hint_and_an_amcl_yaml(run: Run, files, tmp_path: Path):
    log, grid, drive = files
    params = tmp_path / "amcl.yaml"
    params.write_text(amcl_yaml(LocalizationConfig(laser_max_beams=30)) + "    base_frame_id: base\n")
    x, y, yaw = drive.trajectory("true").poses[0]
    status, out, err = run(
        "localize", log, "--map", grid, "--initial-pose", f"{x:.3f},{y:.3f},{yaw:.3f}", "--params", params
    )
    assert status == 0, err
    assert "converged at scan 0" in out or "converged at scan 1" in out
    assert "these say nothing about where the robot is: base_frame_id" in out


def test_the_scans_of_two_lidars(run: Run, files, tmp_path: Path):
    _, grid, drive = files
    path, out = tmp_path / "run.mcap", tmp_path / "poses.tum"
    with path.open("wb") as file:
        write_mcap(file, two_lidars(replace(drive, trajectories={"true": drive.trajectory("true")})))
    both = ("--topic", "/left", "--topic", "/right")
    status, printed, err = run("localize", path, "--map", grid, *both, "--out", out, "--json", "--seed", "1", *FEW)
    assert status == 0, err
    assert json.loads(printed)["scans"] == 2 * drive.n_scans
    off = read_tum(out).poses - np.repeat(drive.trajectory("true").poses, 2, axis=0)
    assert np.hypot(*off[-10:, :2].T).max() < 0.4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--initial-pose", "1,2"], "--initial-pose needs three numbers"),
        (["--initial-pose", "900,2,0"], "is outside the map, which goes from"),
        (["--initial-pose", "nan,2,0"], "three finite numbers"),
        (["--set", "sigma_hit=0"], "sigma_hit"),
        (["--set", "z_hit=nan"], "must be a finite number, not nan"),
        (["--set", "z_hit=0", "--set", "z_rand=0"], "every pose would fit equally well"),
        (["--set", "speed=1"], "There is no localization parameter 'speed'"),
        (["--set", "speed"], "--set needs NAME=VALUE"),
        (["--trajectory", "tf"], "The log has no trajectory 'tf'"),
        (["--params", "nothing.yaml"], "cannot be read"),
        (["--out", "/proc/nothing/poses.tum"], "cannot be written"),
    ],
)
def test_bad_options(run: Run, files, arguments: list[str], said: str):
    status, out, err = run("localize", files[0], "--map", files[1], *FEW, *arguments)
    assert (status, out) == (2, "")
    assert said in err


def test_a_map_that_is_missing(run: Run, files):
    status, _, err = run("localize", files[0], "--map", "no.yaml")
    assert status == 2
    assert "There is no file 'no.yaml'" in err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("z_hit: .nan", "(z_hit) must be a finite number"),
        ("max_particles: -5", "max_particles"),
        ("robot_model_type: tank", "robot_model_type must be one of"),
    ],
)
def test_an_amcl_yaml_with_an_error(run: Run, files, tmp_path: Path, line: str, said: str):
    params = tmp_path / "amcl.yaml"
    params.write_text(f"amcl:\n  ros__parameters:\n    {line}\n")
    status, out, err = run("localize", files[0], "--map", files[1], "--params", params)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert said in err


def test_a_map_without_free_cells(run: Run, files, tmp_path: Path):
    grid = OccupancyGrid(office()[0].geometry)
    grid.log_odds[:], grid.observed[:] = 3.5, True
    full = save_map(grid, tmp_path / "full", "trinary")[0]
    out = tmp_path / "new" / "poses.tum"
    status, printed, err = run("localize", files[0], "--map", full, "--out", out)
    assert (status, printed) == (2, "")
    assert "The map has no free cells" in err
    assert not out.exists()


def test_poses_of_a_file_take_the_place_of_odometry_that_the_log_lacks(run: Run, files, tmp_path: Path):
    _, grid, drive = files
    log, tum = tmp_path / "bare.mcap", tmp_path / "odometry.tum"
    angles, limits = (drive.angle_min, drive.angle_increment), (drive.range_min, drive.range_max)
    scans = [
        recorded.scan(int(stamp) + T0, ranges, angles=angles, limits=limits)
        for stamp, ranges in zip(drive.stamps_ns, drive.ranges, strict=True)
    ]
    log.write_bytes(recorded.mcap_bytes(scans))
    command = ("localize", log, "--map", grid, "--json", "--seed", "1", *FEW)
    status, _, err = run(*command)
    assert (status, err.count("\n")) == (2, 1)
    assert f"`gridbloom slam {log} --out out/slam` writes it: then add --tum-trajectory out/slam.tum here." in err

    lines = []
    for stamp, (x, y, yaw) in zip(drive.stamps_ns, drive.trajectory("odometry").poses, strict=True):
        at = int(stamp) + T0
        turned = f"{np.sin(yaw / 2):.9f} {np.cos(yaw / 2):.9f}"
        lines.append(f"{at // 10**9}.{at % 10**9:09d} {x:.6f} {y:.6f} 0 0 0 {turned}\n")
    tum.write_text("".join(lines))
    status, printed, err = run(*command, "--tum-trajectory", tum)
    assert status == 0, err
    facts = json.loads(printed)
    assert (facts["odometry"], facts["last_converged"]) == ("tum", True)
