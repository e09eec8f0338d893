from __future__ import annotations

import math

import numpy as np

from mapper.io.logs import open_log


def test_each_scan_of_a_dpslam_log_has_the_odometry_before_it(tmp_path):
    path = tmp_path / "loop.log"
    readings = " ".join(["2.5"] * 180 + ["8.183001"])
    path.write_text(f"Odometry 1 2 0.5 \nLaser 181 {readings}\nOdometry 2 2 0.6\nLaser 181 {readings}\n")
    log = open_log(path)
    assert log.format == "DP-SLAM"
    assert log.trajectory().poses.tolist() == [[1, 2, 0.5], [2, 2, 0.6]]
    assert log.angle_increment == math.radians(1.0)
    assert log.ranges[0, 0] == 2.5
    assert np.isposinf(log.ranges[:, 180]).all()
    assert any("no times" in note for note in log.notes)
