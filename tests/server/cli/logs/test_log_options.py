"""The commands that map a log, or find poses for its map, take one set of options, and mean the same by them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.io.export import write_mcap
from mapper.io.maps import save_map
from mapper.io.trajectories import read_tum
from mapper.sensors.scan import ScanLog, Trajectory
from server.cli.commands import load
from tests.mapper.io.logs.recorded import SECOND, cloud, scan, transform, written
from tests.mapper.localization.rooms import office
from tests.server.cli.running import Run

OF_A_LOG = {"--topic", "--trajectory", "--tum-trajectory", "--tf", "--mount", "--mount-upside-down", "--time-offset"}
#: Of these commands fewer have a meaning: each of two logs would need its own trajectory, poses are what is evaluated,
#: clouds are placed in three dimensions, by tf or by --poses, and a TUM file is of one log.
FEWER = {
    "merge": OF_A_LOG - {"--trajectory", "--tum-trajectory"},
    "evaluate": {"--topic", "--tf"},
    "map3d": {"--topic", "--tf", "--trajectory", "--time-offset"},
    "fleet": OF_A_LOG - {"--tum-trajectory"},
}
WHOLE = ("info", "doctor", "check", "report", "map", "why", "compare", "match", "slam", "localize", "bench map")


@pytest.mark.parametrize("name", [*WHOLE, *FEWER])
def test_every_command_that_reads_a_log_has_the_options_of_a_log(name: str) -> None:
    first, *rest = name.split()
    command: Any = load(first)
    for word in rest:
        command = command.commands[word]
    options = {option for one in command.params for option in one.opts}
    assert FEWER.get(name, OF_A_LOG) - options == set()


POSES = {"": [(0.0, 0.0), (0.2, 0.0)], "_gt": [(0.0, 0.0), (0.4, 0.3)]}  #: of both scans, by the topics of transforms


@pytest.fixture
def both(tmp_path: Path) -> Path:
    """A recording of scans and clouds with transforms on /tf and on /tf_gt, and a TUM file of the latter's poses."""
    said = [transform(0, "base_link", name, 0.0, 0.0, topic="/tf_static") for name in ("laser", "velodyne")]
    rows = []
    for k in range(2):
        at = (10 + k) * SECOND
        for ending, poses in POSES.items():
            said.append(transform(at, f"odom{ending}", "base_link", *poses[k], topic=f"/tf{ending}"))
        beams = np.hypot(2.0, np.linspace(-1.5, 1.5, 61))
        said += [scan(at, beams, angles=(-0.6435, 0.02145)), cloud(at, [[2.05, 0.55, 0.35], [2.05, 1.05, 0.35]])]
        rows.append(f"{10 + k} {POSES['_gt'][k][0]} {POSES['_gt'][k][1]} 0 0 0 0 1\n")
    (tmp_path / "gt.tum").write_text("".join(rows))
    return written(tmp_path, said, "mcap")


@pytest.mark.parametrize("named", [("--topic", "/scan", "--tf", "/tf_gt"), ("--topic", "/scan#/tf_gt")])
def test_match_and_evaluate_take_the_transforms_that_are_named(run: Run, both: Path, named: tuple[str, ...]) -> None:
    def guess(*options: str) -> list[float]:
        return json.loads(run("match", both, "--scans", 0, 1, *options, "--json").out)["guess"]  # type: ignore[no-any-return]

    assert guess("--topic", "/scan") == pytest.approx([0.2, 0.0, 0.0])
    assert guess(*named) == pytest.approx([0.4, 0.3, 0.0])
    told = run("evaluate", both.parent / "gt.tum", both, "--align", "none", "--delta", "1", "--delta-unit", "frames",
               *named, "--json")  # fmt: skip
    assert json.loads(told.out)["absolute"]["translation_m"]["max"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("named", [("--topic", "/points", "--tf", "tf_gt"), ("--topic", "/points#/tf_gt")])
def test_clouds_and_the_scans_cut_out_of_them_follow_the_transforms_that_are_named(
    run: Run, both: Path, named: tuple[str, ...]
) -> None:
    def length(*options: str) -> float:
        told = json.loads(run("info", both, *options, "--json").out)
        return float(told["trajectories"][0]["length_m"])

    def high(*options: str) -> list[float]:
        told = run("map3d", both, *options, "--resolution", "0.1", "--out", both.with_suffix(".bt"), "--json")
        return json.loads(told.out)["high"]  # type: ignore[no-any-return]

    assert length("--topic", "/points") == pytest.approx(0.2)
    assert length(*named) == pytest.approx(0.5)
    assert np.subtract(high(*named), high("--topic", "/points")) == pytest.approx([0.2, 0.3, 0.0])


def test_clouds_are_mapped_along_one_source_of_poses(run: Run, both: Path) -> None:
    out = ("--out", both.with_suffix(".bt"))
    told = run("map3d", both, "--trajectory", "tf/odom", "--poses", both.parent / "gt.tum", *out)
    assert (told.status, "give one of them" in told.err) == (2, True)
    told = run("map3d", both, "--trajectory", "gps", *out)
    assert (told.status, "no trajectory 'gps'" in told.err) == (2, True)
    assert "time_offset" in run("map3d", both, "--time-offset", "nan", *out).err


@pytest.mark.parametrize("command", ["info", "map3d"])
def test_transforms_that_a_log_lacks_are_refused(run: Run, both: Path, command: str) -> None:
    out = ("--out", both.with_suffix(".bt")) if command == "map3d" else ()
    told = run(command, both, "--tf", "/other", *out)
    assert told.status == 2
    assert "no transforms on '/other'; it has /tf, /tf_gt." in told.err
    text = both.with_suffix(".log")
    text.write_text("FLASER 2 1.0 1.0 0 0 0 0 0 0 1.0 host 1.0\n")
    assert "its format has none" in run("info", text, "--tf", "/tf").err


def recorded(path: Path, log: ScanLog, mount: tuple[float, float, float], name: str) -> Path:
    """Write a log whose poses are those of a base on which the sensor sits at ``mount``, which it states as 0."""
    base = compose(log.trajectory(name).poses, inverse(np.array(mount)))
    with path.open("wb") as file:
        write_mcap(file, replace(log, trajectories={"odometry": Trajectory(base, frame_id="odom")}))
    return path


def test_a_mount_that_is_corrected_is_localized_as_one_that_is_right(run: Run, tmp_path: Path) -> None:
    grid, log = office()
    save_map(grid, tmp_path / "office", "trinary")
    mount = (0.3, -0.2, 0.0)
    path = recorded(tmp_path / "office.mcap", log, mount, "odometry")
    base = compose(log.trajectory("true").poses, inverse(np.array(mount)))
    start = ",".join(f"{value:.3f}" for value in base[0])
    out = tmp_path / "poses.tum"
    given = ("--mount", ",".join(map(str, mount)), "--initial-pose", start)
    status, printed, err = run("localize", path, "--map", tmp_path / "office.yaml", *given, "--out", out, "--json")
    assert status == 0, err
    assert json.loads(printed)["last_converged"]
    off = read_tum(out).poses - base
    assert np.hypot(*off[-10:, :2].T).max() < 0.2


def test_info_says_what_map_says_and_follows_the_correction(run: Run, tmp_path: Path) -> None:
    _, log = office()
    turned = recorded(tmp_path / "turned.mcap", log, (0.0, 0.0, np.pi / 2), "true")
    cause = json.loads(run("map", turned, "--json").out)["cause"]
    assert cause is not None
    assert cause.startswith("The laser fits much better turned by 90° to the left")
    assert cause in json.loads(run("info", turned, "--json").out)["notes"]
    corrected = json.loads(run("info", turned, "--mount", f"0,0,{np.pi / 2}", "--json").out)["notes"]
    assert not [note for note in corrected if "laser fits" in note]
