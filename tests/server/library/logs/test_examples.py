"""The example logs: each has what it is for, against the world and the run that it was simulated from."""

from __future__ import annotations

import io
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from PIL import Image

from mapper.diagnosis import diagnose
from mapper.io.contents.pictures import picture_of
from mapper.io.logs import open_log
from mapper.mapping.parameters import MappingConfig
from mapper.replay.map_series import map_series
from mapper.sensors.scan import ScanLog
from mapper.simulation import WORLDS
from mapper.simulation.sample import sample_log
from mapper.volume.scans.scan_sequence import gather
from server.library.logs.examples import FILES, SCANS, STATED_YAW, ExampleName, example_bytes

made_once = cache(example_bytes)  # the sensors of "camera" are simulated for a second


def opened(name: ExampleName, folder: Path) -> tuple[Path, ScanLog]:
    path = folder / FILES[name]
    path.write_bytes(made_once(name))
    return path, open_log(path)


def test_the_poses_of_one_drift_and_contradict_their_map(tmp_path: Path) -> None:
    _, log = opened("drift", tmp_path)
    true = sample_log()
    gap = np.hypot(*(log.trajectory().poses - true.trajectory("odometry").poses)[:, :2].T)
    assert gap.max() < 1e-6
    assert np.hypot(*(log.trajectory().poses - true.trajectory("true").poses)[:, :2].T).max() > 0.3
    first = slice(0, 300)  # in which they drift enough
    found, right = (np.nanmean(map_series(one.take(first), MappingConfig()).values[:, 2]) for one in (log, true))
    assert found > 1.5 * right


def test_the_doctor_finds_the_mount_of_one(tmp_path: Path) -> None:
    _, log = opened("mount", tmp_path)
    assert log.mount[2] == pytest.approx(STATED_YAW)
    (finding,) = diagnose(log).findings
    assert finding.check == "mount.offset"
    assert (finding.parameters or {})["mount_yaw"] == pytest.approx(-STATED_YAW, abs=0.01)


def test_one_has_the_clouds_of_a_room_and_images_of_it(tmp_path: Path) -> None:
    path, log = opened("camera", tmp_path)
    assert log.n_scans == SCANS
    scans = gather(path)
    assert len(scans) == SCANS // 2
    np.testing.assert_allclose(scans.origins[:, 2], 0.6, atol=1e-6)
    assert scans.points[:, 2].min() > -0.1
    low = scans.points[(scans.points[:, 2] > 0.5) & (scans.points[:, 2] < 0.7)]  # above the floor
    assert (np.abs(WORLDS["office"].clearance(low[:, :2].astype(np.float64))) < 0.06).mean() > 0.95
    with path.open("rb") as file:
        images = [one.data for _, _, one in make_reader(file).iter_messages("/camera/image")]
    assert len(images) == SCANS // 2
    shown = [Image.open(io.BytesIO(picture_of("sensor_msgs/Image", data, cdr=True)[0])) for data in images[:20:19]]
    assert shown[0].size == (160, 120)
    first, later = (np.asarray(one.convert("RGB")).astype(int) for one in shown)
    assert np.abs(first - later).mean() > 5.0
    assert np.ptp(first[:60], axis=(0, 1)).min() > 30


@pytest.mark.parametrize("name", FILES)
def test_each_is_the_same_file_each_time(name: ExampleName) -> None:
    assert example_bytes(name) == made_once(name)
