"""The job that merges two logs, in this process: what it leaves are poses in one frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mapper.evaluation import absolute_errors, align
from mapper.io.trajectories import read_tum
from mapper.sensors.robot_log import RobotLog
from server.library.log_pack import write_pack
from server.library.merge_job import ENDINGS, MergeJob, _merge
from tests.mapper.slam.test_merge import FIRST, SECOND, WIDE, in_frame
from tests.mapper.slam.worlds import along, drive


def test_it_leaves_a_trajectory_of_each_log_in_one_frame(tmp_path: Path) -> None:
    first = in_frame(drive("loop", along([*FIRST, (22.7, 1.25), (22.7, 4.0)], 0.4), sensor=WIDE), (3.0, 1.0, 0.3))
    second = in_frame(drive("loop", along(SECOND, 0.4), seed=8), (-4.0, 9.0, 2.5))
    packs = []
    for name, log in (("first", first), ("second", second)):
        packs.append(tmp_path / f"{name}.npz")
        write_pack(RobotLog.of_one(log), packs[-1])
    outcome = _merge(MergeJob(str(packs[0]), str(packs[1]), str(tmp_path / "out"), 60.0, 60.0, 1 << 32))
    assert 3 <= outcome.loops <= outcome.tried
    poses = [read_tum(tmp_path / f"out{ending}") for ending in ENDINGS]
    for log, own in zip((first, second), poses, strict=True):
        np.testing.assert_array_equal(own.stamps_ns, log.stamps_ns)
    true = np.concatenate([log.trajectory("true").poses for log in (first, second)])
    found = np.concatenate([own.poses for own in poses])
    assert absolute_errors(true, align(true, found).apply(found))[0].max() < 0.2
