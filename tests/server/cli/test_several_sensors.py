"""Sonars on several topics, and scans cut out of clouds, mapped on the command line."""

from __future__ import annotations

from pathlib import Path

from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import transform
from tests.mapper.io.logs.test_clouds import recording_of_room
from tests.server.cli.running import Run, state_counts


def test_all_sonars_make_one_map_where_there_is_no_lidar(run: Run, tmp_path: Path) -> None:
    bearings = [-1.0, 0.0, 1.0]
    said = [
        transform(recorded.SECOND, "base_link", f"sonar{n}", 0.1 * n, 0.0, bearing, topic="/tf_static")
        for n, bearing in enumerate(bearings)
    ]
    for i in range(1, 6):
        at = i * recorded.SECOND
        said.append(transform(at, "odom", "base_link", 0.1 * i))
        said += [recorded.sonar(at + n, 2.0, f"/sonar/{n}", f"sonar{n}") for n in range(3)]
    path = recorded.written(tmp_path, said, "bag")
    facts = state_counts(run, path)
    assert [one["topic"] for one in facts["sensors"]] == ["/sonar/0", "/sonar/1", "/sonar/2"]
    alone = [state_counts(run, path, "--topic", f"/sonar/{n}") for n in range(3)]
    assert facts["cells_updated"] == sum(one["cells_updated"] for one in alone)
    assert any("one of 3 sonars, which make one map" in note for note in facts["notes"])


def test_a_cloud_is_mapped_and_the_height_band_chooses_its_points(run: Run, tmp_path: Path) -> None:
    path = recorded.written(tmp_path, recording_of_room(), "mcap")
    walls = state_counts(run, path, "--min-height", "0.1", "--max-height", "2", "--angle-increment", "0.02")
    assert (walls["scans"], walls["beams"]) == (4, 315)
    assert walls["occupied"] > 100
    assert state_counts(run, path, "--min-height", "2.6", "--max-height", "3")["occupied"] == 0
    for options, said in (
        (("--min-height", "3", "--max-height", "2"), "least height must be below the greatest"),
        (("--angle-increment", "soon"), "must be a finite number"),
    ):
        status, _, err = run("map", path, *options)
        assert (status, err.count("\n")) == (2, 1)
        assert said in err
