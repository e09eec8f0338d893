"""``gridbloom slam``: what it writes, read again by the project's readers."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.evaluation import absolute_errors, align
from mapper.io.export import write_mcap
from mapper.io.graphs import read_g2o
from mapper.io.maps import load_map
from mapper.io.trajectories import read_tum
from mapper.sensors.scan import ScanLog, Trajectory
from tests.bench.event_runs import RATE_HZ, Happening, free_scans
from tests.bench.event_runs import drive as pushed
from tests.mapper.slam.worlds import along, drive
from tests.server.cli.running import Run


def carmen(path: Path, log: ScanLog) -> Path:
    """Write a log with the odometry poses as CARMEN text."""
    lines = []
    for ranges, stamp, (x, y, a) in zip(log.ranges, log.stamps_ns, log.trajectory("odometry").poses, strict=True):
        values = " ".join(f"{8.18 if np.isinf(r) else r:.3f}" for r in ranges)
        pose = f"{x:.6f} {y:.6f} {a:.6f}"
        lines.append(f"FLASER {len(ranges)} {values} {pose} {pose} {stamp / 1e9:.3f} host {stamp / 1e9:.3f}\n")
    path.write_text("PARAM robot_frontlaser_offset 0\n" + "".join(lines))
    return path


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    path = along([(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)], 0.4)
    log = drive("room", path, turn_bias=0.1)
    return carmen(tmp_path_factory.mktemp("slam") / "room.log", log), path


def test_writes_map_trajectory_and_graph(run: Run, room: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    log, true = room
    prefix = tmp_path / "maps" / "room"
    status, out, err = run("slam", log, "--out", prefix, "--json", "--set", "refinement=2")
    assert status == 0, err
    facts = json.loads(out)
    assert facts["scans"] == len(true)
    assert facts["sharpness_after"] > facts["sharpness_before"]
    assert {"cpu_seconds", "loops", "residuals"} <= set(facts)
    poses = read_tum(f"{prefix}.tum")
    assert len(poses) == len(true)
    # The odometry turns by 0.1 rad on each metre of ten; a CARMEN log states no bearings, so they are off by 1 %.
    assert absolute_errors(true, align(true, poses.poses).apply(poses.poses))[0].max() < 0.4
    graph = read_g2o(f"{prefix}.g2o")
    np.testing.assert_allclose(graph.poses, poses.poses[graph.nodes], atol=1e-5)
    assert load_map(f"{prefix}.yaml").grid.observed.any()
    assert sorted(path.name for path in prefix.parent.iterdir()) == ["room.g2o", "room.pgm", "room.tum", "room.yaml"]


def test_two_logs_are_merged(run: Run, room: tuple[Path, np.ndarray], tmp_path: Path) -> None:
    """The room again, from the other side, with odometry that begins at zero."""
    log, true = room
    back = true[::-1] + np.array([0.0, 0.3, np.pi])
    other = drive("room", back, turn_bias=0.02, seed=9)
    wheels = other.trajectory("odometry").poses
    moved = Trajectory(compose(inverse(wheels[0]), wheels), "wheels", "odom")
    second = carmen(tmp_path / "other.log", replace(other, trajectories={"odometry": moved}))
    status, out, err = run("merge", log, second, "--out", tmp_path / "both", "--json")
    assert status == 0, err
    facts = json.loads(out)
    assert facts["loops"] >= 3
    poses = np.concatenate([read_tum(str(tmp_path / f"both-{number}.tum")).poses for number in (1, 2)])
    both = np.concatenate([true, back])
    assert absolute_errors(both, align(both, poses).apply(poses))[0].max() < 0.4
    assert len(read_g2o(str(tmp_path / "both.g2o")).nodes) > len(true) // 2
    status, _, err = run("merge", log, tmp_path / "both.yaml", "--out", tmp_path / "no")
    assert (status, "map files can be merged, or two logs" in err) == (2, True)
    status, _, err = run("merge", log, log, log, "--out", tmp_path / "no")
    assert (status, "two logs at a time, not 3" in err) == (2, True)


def test_says_when_the_robot_was_pushed_and_how_far(run: Run, tmp_path: Path) -> None:
    moved = (0.0, -0.4, 0.0)
    scan = int(free_scans("office", 400, 4, moved)[0])
    log = pushed("office", 400, [Happening("pushed", scan, 2, moved)], seed=4)
    path = tmp_path / "pushed.mcap"
    with path.open("wb") as file:
        write_mcap(file, log)
    least = ("--set", "loop_closure=off", "--set", "refinement=0")  # the events are those of the log
    status, out, err = run("slam", path, "--json", *least)
    assert status == 0, err
    (event,) = json.loads(out)["events"]
    assert (event["kind"], event["direction"]) == ("pushed", "right")
    assert event["seconds"] == pytest.approx(scan / RATE_HZ, abs=1.0 / RATE_HZ)
    assert event["distance_m"] == pytest.approx(0.4, abs=0.08)
    assert f"  {event['sentence']}\n" in run("slam", path, *least).out


def test_says_what_it_found(run: Run, room: tuple[Path, np.ndarray]) -> None:
    status, out, _ = run("slam", room[0], "--set", "loop_closure=off", "--set", "refinement=0")
    assert status == 0
    assert "0 loops closed of 0 tried" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--set", "refinement"], "--set needs NAME=VALUE, not 'refinement'"),
        (["--set", "refinement=many"], "refinement"),
        (["--set", "speed=1"], "There is no SLAM parameter 'speed'"),
        (["--trajectory", "tf"], "The log has no trajectory 'tf'"),
    ],
)
def test_bad_options(run: Run, room: tuple[Path, np.ndarray], arguments: list[str], said: str) -> None:
    status, out, err = run("slam", room[0], *arguments)
    assert (status, out) == (2, "")
    assert said in err
