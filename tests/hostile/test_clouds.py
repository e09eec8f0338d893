"""Clouds and depth images as no sensor sends them: absurd sizes, numbers that are none, thousands that wait for tf."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.logs.recording import cutting
from mapper.io.logs.ros.cloud_messages import PART_POINTS
from mapper.sensors.scan import ScanLog
from tests.hostile.corpus import T0
from tests.hostile.damage import opened
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import Said, camera, cloud, image, transform


def only(tmp_path: Path, *said: Said) -> ScanLog | Exception:
    return opened(tmp_path / "a.log", recorded.mcap_bytes([transform(T0, "base_link", "velodyne"), *said]))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"width": 2**32 - 1}, "do not fit its 36 bytes"),
        ({"height": 2**32 - 1}, "do not fit its 36 bytes"),
        ({"height": 2**16, "width": 2**16, "point_step": 12, "row_step": 2**32 - 1}, "do not fit its 36 bytes"),
        ({"point_step": 2**32 - 1}, "do not fit its 36 bytes"),
    ],
)
def test_clouds_of_absurd_size(tmp_path: Path, change: dict[str, Any], why: str) -> None:
    bad = cloud(T0, np.ones((3, 3)))
    bad.fields |= change
    refused = only(tmp_path, bad)
    assert isinstance(refused, ReadError)
    assert why in refused.message
    log = only(tmp_path, bad, cloud(T0 + 1, np.ones((3, 3))))
    assert isinstance(log, ScanLog)
    assert log.n_scans == 1, "the good one is there"
    assert any(why in note for note in log.notes)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"width": 2**31}, "an image of 2147483648"),
        ({"height": 2**16, "step": 2**16}, "do not fit its"),
        ({"step": 3}, "do not fit its"),
    ],
)
def test_images_of_absurd_size(tmp_path: Path, change: dict[str, Any], why: str) -> None:
    bad = image(T0, np.ones((4, 6)))
    bad.fields |= change
    refused = only(tmp_path, camera(T0, (6, 4), 5.0), bad)
    assert isinstance(refused, ReadError)
    assert why in refused.message


def test_points_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    points = np.array([[np.nan, 1, 1], [np.inf, 1, 1], [1e300, 1, 1], [-1e300, 1, 1], [2.0, 0.0, 1.0]])
    log = only(tmp_path, cloud(T0, points, layout=[("x", "f8"), ("y", "f8"), ("z", "f8")]))
    assert isinstance(log, ScanLog)
    assert log.ranges[np.isfinite(log.ranges)].tolist() == [2.0]


def test_a_cloud_of_more_points_than_are_taken_at_once(tmp_path: Path) -> None:
    points = np.ones((PART_POINTS + 7, 3))
    points[-1] = [-3.0, 0.1, 1.0]  # in the last part
    for rows in (1, PART_POINTS + 7):
        log = only(tmp_path, cloud(T0, points, rows=rows))
        assert isinstance(log, ScanLog)
        np.testing.assert_allclose(sorted(log.ranges[np.isfinite(log.ranges)]), [2**0.5, 9.01**0.5], rtol=1e-6)


def test_clouds_that_wait_for_transforms_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "HELD_BYTES", 1000)
    held = []
    finish = cutting.Cutter.finish

    def counted(cutter: cutting.Cutter) -> None:
        held.append(len(cutter._held))
        finish(cutter)

    monkeypatch.setattr(cutting.Cutter, "finish", counted)
    said = [cloud(T0 + i, np.ones((3, 3))) for i in range(50)]
    log = opened(tmp_path / "a.log", recorded.mcap_bytes([*said, transform(T0, "base_link", "velodyne", z=1.0)]))
    assert isinstance(log, ScanLog)
    assert log.n_scans == 50, "nothing is lost"
    assert max(held) < 12
    assert any("before its clouds were cut" in note for note in log.notes)
