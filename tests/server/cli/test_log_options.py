"""The commands that map a log, or find poses for its map, take one set of options, and mean the same by them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer

from mapper.core.se2 import compose, inverse
from mapper.io.export import write_mcap
from mapper.io.maps import save_map
from mapper.io.trajectories import read_tum
from mapper.sensors.scan import ScanLog, Trajectory
from server.cli import app
from tests.mapper.localization.rooms import office
from tests.server.cli.running import Run

OF_A_LOG = {"--topic", "--trajectory", "--tum-trajectory", "--tf", "--mount", "--mount-upside-down", "--time-offset"}
OF_TWO_LOGS = OF_A_LOG - {"--trajectory", "--tum-trajectory"}  #: of which each log would need its own


@pytest.mark.parametrize("name", ["info", "doctor", "check", "map", "why", "compare", "slam", "localize", "merge"])
def test_every_command_that_maps_a_log_has_the_options_of_a_log(name: str) -> None:
    command = typer.main.get_command(app).commands[name]  # type: ignore[attr-defined]
    options = {option for one in command.params for option in one.opts}
    assert (OF_TWO_LOGS if name == "merge" else OF_A_LOG) - options == set()


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
