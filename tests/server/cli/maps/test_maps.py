"""``map`` and ``view``: what they print and write."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from mapper.io.maps import load_map
from mapper.mapping.parameters import MODELS, PARAMETERS
from server.cli.common import SHORT_NAMES
from tests.mapper.io.logs import recorded
from tests.server.cli.running import state_counts

ROOT = Path(__file__).parents[4]


def test_map_as_json_has_the_figures_that_programs_need(run, log, tmp_path):
    status, out, err = run("map", log, "--json", "--resolution", 0.1, "--out", tmp_path / "out" / "room")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert (facts["scans"], facts["beams"], facts["trajectory"], facts["resolution"]) == (4, 180, "scan", 0.1)
    assert 4 * 179 * 14 < facts["cells_updated"] < 4 * 179 * 22  # 2 m are 14 cells on the diagonal, 20 along an axis
    assert facts["seconds"] > 0.0
    written = yaml.safe_load((tmp_path / "out" / "room.yaml").read_text())
    assert written["origin"] == facts["origin"]
    assert written["resolution"] == 0.1
    header = (tmp_path / "out" / "room.pgm").read_bytes().split(b"\n", 3)
    assert header[:2] == [b"P5", f"{facts['cols']} {facts['rows']}".encode()]
    assert header[3].count(0) == facts["occupied"] > 100  # a circle of radius 20 cells is about 113 of them
    assert header[3].count(254) == facts["free"] > 1100  # its area is about 1,257
    assert facts["files"] == [str(tmp_path / "out" / "room.pgm"), str(tmp_path / "out" / "room.yaml")]


def test_sizes_are_width_by_height_as_in_the_image(run, tmp_path):
    log = tmp_path / "wide.log"
    log.write_text("FLASER 1 1 0 0 0 0 0 0 0 host 0\nFLASER 1 1 9 0 0 9 0 0 1 host 1\n")
    mapped = run("map", log, "--out", tmp_path / "wide").out
    width, height = (int(n) for n in (tmp_path / "wide.pgm").read_bytes().split(b"\n", 2)[1].split())
    assert width > height
    viewed = run("view", tmp_path / "wide.yaml").out
    merged = run("merge", tmp_path / "wide.yaml", "--out", tmp_path / "same").out
    for out in (mapped, viewed, merged):
        assert f"{width} × {height} cells of 0.05 m" in out


def test_map_writes_the_log_as_mcap_and_tum(run, log, tmp_path):
    mcap, tum = tmp_path / "run.mcap", tmp_path / "way.tum"
    facts = json.loads(run("map", log, "--mcap", mcap, "--tum", tum, "--json").out)
    assert facts["files"] == [str(mcap), str(tum)]
    again = json.loads(run("info", mcap, "--json").out)
    assert (again["scans"], again["beams"]) == (4, 180)
    rows = np.loadtxt(tum)
    np.testing.assert_allclose(rows[:, 0], np.arange(4.0))
    np.testing.assert_allclose(2 * np.arctan2(rows[:, 6], rows[:, 7]) % (2 * np.pi), np.arange(4) * np.pi / 2)
    status, _, err = run("map", log, "--tum", tmp_path / "nowhere" / "way.tum")
    assert (status, err.count("\n")) == (2, 1)
    assert "cannot be written: No such file" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap", "way.tum"]


def test_map_prints_the_written_files(run, log, tmp_path):
    status, out, err = run("map", log, "--out", tmp_path / "room")
    assert (status, err) == (0, "")
    assert "4 scans of 180 beams, trajectory scan" in out
    assert f"wrote {tmp_path / 'room.yaml'}" in out


def test_each_row_of_the_parameter_table_is_an_option_and_its_sentence_is_in_the_help(run):
    status, out, _ = run("map", "--help")
    words = " ".join(out.split())
    assert status == 0
    for row in PARAMETERS:
        if row.group == "mount":
            continue
        assert "--" + row.name.replace("_", "-") in words
        assert SHORT_NAMES.get(row.name, "") in words
        assert row.sentence in words


def test_options_change_the_map(run, log):
    plain = state_counts(run, log)
    assert state_counts(run, log, "--max-range", 1.5)["occupied"] == 0
    assert state_counts(run, log, "--window", 0.5)["occupied"] > plain["occupied"]
    assert state_counts(run, log, "--hit", 0.0)["occupied"] == 0
    assert state_counts(run, log, "--miss", 0.0)["free"] == 0
    assert state_counts(run, log, "--model", "step-window", "--window", 0.3)["occupied"] > plain["occupied"]
    assert state_counts(run, log, "--no-return", "free", "--max-range", 3)["free"] > plain["free"]
    assert state_counts(run, log, "--prior", 1.0)["occupied"] > 0
    assert state_counts(run, log, "--update", "per-scan")["cells_updated"] < plain["cells_updated"]
    assert state_counts(run, log, "--no-clamp")["cells_updated"] == plain["cells_updated"]
    assert state_counts(run, log, "--trajectory", "wheel")["trajectory"] == "wheel"


@pytest.mark.parametrize("model", [model.replace("_", "-") for model in MODELS])
@pytest.mark.parametrize("update", ["per-beam", "per-scan"])
def test_every_model_maps_from_the_command_line(run, log, model, update):
    facts = state_counts(run, log, "--model", model, "--update", update, "--no-return", "hit")
    assert facts["cells_updated"] > 1000
    assert facts["information_gain_bits"] > 0


def test_mapping_continues_from_a_map_file(run, log, tmp_path):
    known = state_counts(run, log, "--out", tmp_path / "known", "--resolution", 0.1)
    again = state_counts(run, log, "--prior", tmp_path / "known.yaml", "--hit", 0, "--miss", 0)
    same = ("resolution", "rows", "cols", "origin", "occupied", "free", "unknown")
    assert {name: again[name] for name in same} == {name: known[name] for name in same}
    status, out, err = run("map", log, "--prior", tmp_path / "known.yaml", "--resolution", 0.05)
    assert (status, out) == (2, "")
    assert err == (
        f"gridbloom: {tmp_path / 'known.yaml'}: The prior map has cells of 0.1 m and the map to be made of 0.05 m; "
        "they must be the same.\n"
    )
    coarse = tmp_path / "coarse.yaml"
    coarse.write_text((tmp_path / "known.yaml").read_text().replace("resolution: 0.1", "resolution: 2.5"))
    status, out, err = run("map", log, "--prior", coarse)
    assert (status, out) == (2, "")
    assert err == f"gridbloom: {coarse}: Resolution (resolution) must be between 0.01 and 1 m, not 2.5.\n"
    status, out, err = run("map", log, "--prior", tmp_path / "gone.yaml")
    assert (status, out) == (2, "")
    assert "There is no file 'gone.yaml'" in err


def test_a_ring_of_sonars_maps_from_its_folder(run, tmp_path):
    (tmp_path / "measurement.txt").write_text("".join(f"{200 * t} 2000 2000 2000 5110\n" for t in range(20)))
    (tmp_path / "poses.txt").write_text("".join(f"{200 * t} {10 * t} 0 0\n" for t in range(20)))
    cones = state_counts(run, tmp_path)
    assert cones["free"] > 2 * state_counts(run, tmp_path, "--model", "fixed-increments")["free"]
    assert cones["cells_updated"] > state_counts(run, tmp_path, "--opening", 0.1)["cells_updated"]
    # The other commands make the same map of it.
    measured = json.loads(run("bench", "map", tmp_path, "--repeats", 1, "--json").out)
    assert measured["cells"] == cones["cells_updated"]
    assert json.loads(run("compare", tmp_path, "--json").out)["cells"] == cones["rows"] * cones["cols"]


def test_the_mount_moves_the_map(run, log):
    plain, moved = state_counts(run, log), state_counts(run, log, "--mount", "-1.5,0,3.14159")
    # Whole tiles of 3.2 m on each side of the origin: the room ends at 2 m, or at 1.5 m + 2 m behind the robot.
    assert (plain["rows"], plain["cols"]) == (128, 128)
    assert (moved["rows"], moved["cols"]) == (256, 256)


def test_a_map_that_would_be_too_large_is_refused(run, tmp_path):
    log = tmp_path / "far.log"
    tail = "1 host 1"
    log.write_text(f"FLASER 1 1 0 0 0 0 0 0 {tail}\nFLASER 1 1 900000 900000 0 900000 900000 0 {tail}\n")
    status, _, err = run("map", log)
    assert status == 2
    assert "choose a coarser resolution" in err


def test_a_map_that_cannot_be_written_is_refused(run, log, tmp_path):
    (tmp_path / "file").write_text("")
    status, _, err = run("map", log, "--out", tmp_path / "file" / "room")
    assert status == 2
    assert "cannot be written" in err


def test_view_draws_both_pictures_as_wide_as_the_terminal(run, log, tmp_path, monkeypatch):
    assert run("map", log, "--out", tmp_path / "room", "--resolution", 0.1).status == 0
    monkeypatch.setenv("COLUMNS", "40")
    status, out, err = run("view", tmp_path / "room.yaml")
    assert (status, err) == (0, "")
    title, states, ramp = out.rstrip("\n").split("\n\n")
    assert "trinary" in title
    first, *picture = states.split("\n")
    assert first == "# occupied   . free   ? unknown"
    assert max(map(len, picture)) == 40
    # A circle: wall at the top in the middle, unknown in the corners, free in the centre.
    assert picture[0][20] == "#"
    assert picture[0][0] == picture[-1][-1] == "?"
    assert picture[len(picture) // 2][20] == "."
    assert "@" in ramp
    assert len(ramp.split("\n")) == len(picture) + 1


def test_view_of_a_bad_map_prints_one_sentence_and_exits_with_status_2(run, tmp_path):
    bad = tmp_path / "m.yaml"
    bad.write_text(
        "image: ../secret.pgm\nresolution: 1\norigin: [0,0,0]\nnegate: 0\noccupied_thresh: 1\nfree_thresh: 0\n"
    )
    status, out, err = run("view", bad)
    assert (status, out) == (2, "")
    assert err == (
        f"gridbloom: {bad}: The map’s yaml names the image '../secret.pgm', outside the yaml’s own folder, and "
        "there is no 'secret.pgm' beside the yaml.\n"
    )
    assert run("view", bad, "--width", 0).status == 2


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs a pseudo-terminal")
def test_progress_is_shown_on_a_terminal_and_not_on_standard_output(log):
    ours, theirs = os.openpty()
    try:
        done = subprocess.run(
            [sys.executable, "-c", "from server.cli import main; main()", "map", str(log), "--json"],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=theirs,
            env=os.environ | {"TERM": "xterm"},
            check=True,
        )
        seen = os.read(ours, 1 << 16).decode()
    finally:
        os.close(ours)
        os.close(theirs)
    assert "Mapping" in seen
    assert json.loads(done.stdout)["scans"] == 4


def two_lidars(folder: Path) -> Path:
    """A robot in a square room of 6 m, with a lidar that looks ahead and one that looks back."""
    at = 1_700_000_000 * recorded.SECOND
    said = [
        recorded.transform(at, "base_link", "front", 0.2, topic="/tf_static"),
        recorded.transform(at, "base_link", "rear", -0.2, yaw=np.pi, topic="/tf_static"),
    ]
    bearings = np.radians(np.arange(180) - 90.0)
    for i in range(10):
        stamp = at + i * recorded.SECOND // 10
        said.append(recorded.transform(stamp, "odom", "base_link", 0.01 * i))
        for frame, x, turn in (("front", 0.2, 0.0), ("rear", -0.2, np.pi)):
            cos, sin = np.cos(bearings + turn), np.sin(bearings + turn)
            x_at = 0.01 * i + x
            ahead, aside = np.maximum(np.abs(cos), 1e-9), np.maximum(np.abs(sin), 1e-9)
            ranges = np.minimum((3.0 - np.sign(cos) * x_at) / ahead, 3.0 / aside)
            angles = (float(bearings[0]), float(bearings[1] - bearings[0]))
            said.append(recorded.scan(stamp, ranges, f"/{frame}", frame, angles))
    return recorded.written(folder, said, "mcap")


def test_two_lidars_make_one_map(run, tmp_path):
    path = two_lidars(tmp_path)
    both = state_counts(run, path, "--topic", "/front", "--topic", "/rear", "--out", tmp_path / "both")
    front, rear = (state_counts(run, path, "--topic", name) for name in ("/front", "/rear"))
    assert both["sensors"] == [{"topic": name, "scans": 10, "beams": 180} for name in ("/front", "/rear")]
    assert both["scans"] == 20
    assert both["cells_updated"] == front["cells_updated"] + rear["cells_updated"]
    assert both["occupied"] > 1.5 * max(front["occupied"], rear["occupied"])
    grid = load_map(tmp_path / "both.yaml").grid
    cells = np.argwhere(grid.p_occ > 0.65)
    off = np.abs(np.abs(grid.geometry.cell_to_world(cells)).max(axis=1) - 3.0)
    assert np.quantile(off, 0.95) < 0.06
    assert "20 scans of 180 beams of 2 sensors" in run("map", path, "--topic", "/front", "--topic", "/rear").out
    assert state_counts(run, path, "--topic", "/front", "--topic", "/rear", "--scans", 3)["scans"] == 3


def test_the_two_scanners_of_a_real_recording_make_one_map(run, data_file):
    path = data_file("bags/scans_demo.bag")
    facts = state_counts(run, path, "--topic", "/front_scan", "--topic", "/rear_scan")
    assert facts["scans"] == 331 + 330
    assert [one["scans"] for one in facts["sensors"]] == [331, 330]
    assert "Where these sensors sit on the robot is not known; all are taken to be in one place." in facts["notes"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--mount", "0.1,0,0"], "the mount is for one sensor"),
        (["--mount-upside-down"], "the mount is for one sensor"),
        (["--topic", "/left"], "'/left'; it has"),
    ],
)
def test_options_for_one_sensor_are_refused_with_two(run, tmp_path, options, words):
    path = two_lidars(tmp_path)
    status, _, err = run("map", path, "--topic", "/front", "--topic", "/rear", *options)
    assert (status, err.count("\n")) == (2, 1)
    assert words in err
