"""Excerpts of logs for a report: what they say, and what must not be in them."""

from __future__ import annotations

import getpass
import json
import socket
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.io.contents.report import excerpt
from tests.mapper.io.logs.driven_robot import T0, run
from tests.mapper.io.logs.recorded import KINDS, SECOND, mcap_bytes, scan, written

READINGS = np.array([2.7183, 3.1416, 4.6692, 7.3891, 5.7722], dtype=np.float32)


def text_of(path: Path) -> tuple[dict[str, Any], str]:
    facts = excerpt(path)
    text = json.dumps(facts, allow_nan=False)
    for name in (path.name, path.stem, path.parent.name, getpass.getuser(), socket.gethostname()):
        assert len(name) < 3 or name not in text.replace(str(facts.get("format")), ""), name
    return facts, text


@pytest.mark.parametrize("kind", KINDS)
def test_no_reading_survives_and_what_explains_the_log_does(tmp_path, kind):
    said = [one for one in run() if one.topic != "/scan"]
    for i in range(30):
        one = scan(T0 + i * SECOND // 10, READINGS + np.float32(0.0137 * i))
        said.append(replace(one, fields=one.fields | {"range_max": float(one.fields["ranges"].max())}))
    said.append(scan(T0 + 4 * SECOND, READINGS, angles=(-1.5, 0.0)))
    folder = tmp_path / "of_somebody"
    folder.mkdir()
    facts, text = text_of(written(folder, said, kind))
    for i in range(30):
        for reading in (READINGS + np.float32(0.0137 * i)).tolist():
            assert f"{reading:.2f}" not in text
            assert f"{reading:.3f}" not in text
    (topic,) = [one for one in facts["topics"] if one["topic"] == "/scan"]
    assert (topic["type"], topic["count"]) == ("sensor_msgs/LaserScan", 31)
    first = topic["first"][0]
    assert (first["frame"], first["beams"], first["angle_min"]) == ("laser", 5, -1.5)
    assert first["readings"] | {"nan": 0} == first["readings"]
    assert first["readings"]["measured"] == 5
    assert any("the angle_increment is 0 rad" in note for note in facts["notes"])
    assert {"parent": "odom", "child": "base_link"}.items() <= facts["transforms"][1].items() or any(
        edge["child"] == "base_link" for edge in facts["transforms"]
    )


def test_of_a_text_log_the_shape_of_its_lines_is_told(tmp_path):
    path = tmp_path / "my_kitchen.log"
    line = "FLASER 3 2.718 3.141 4.669 0.12 0.34 0.56 0.12 0.34 0.56 1.5 somebodys-robot 1.5\n"
    path.write_text("# recorded by somebody at home\n" + 4 * line)
    facts, text = text_of(path)
    assert "4 × FLASER int decimal×10 word decimal" in facts["files"][0]["lines"]
    assert facts["sensors"][0]["parts"][0]["beams"] == 3
    assert not any(word in text for word in ("somebody", "kitchen", "2.718", "home"))


def test_a_file_that_is_not_read_says_why_without_quoting_it(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("somebody 2.718281 my secret\n" * 3)
    facts, text = text_of(path)
    assert facts["error"]["code"] == "log.unknown_format"
    assert facts["files"][0]["lines"] == ["3 × word decimal word×2"]
    assert not any(word in text for word in ("somebody", "secret", "2.718"))
    path = tmp_path / "a.mcap"
    path.write_bytes(mcap_bytes([one for one in run() if one.topic != "/scan"]))
    facts, _ = text_of(path)
    assert facts["error"]["code"] == "log.no_scans"
    assert {one["type"] for one in facts["topics"]} >= {"tf2_msgs/TFMessage", "nav_msgs/Odometry"}
