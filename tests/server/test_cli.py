"""The command line: what it prints, where, and with which exit status."""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml

from mapper.parameters import MODELS, PARAMETERS
from server.cli import SHORT_NAMES, main
from server.settings import Settings
from tests.mapper.logs import recorded

ROOT = Path(__file__).parents[2]


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """A function that runs the command in this process."""

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["gridbloom", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return Outcome(int(ended.value.code or 0), *capsys.readouterr())

    return run


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot in the middle of a round room of 2 m radius, seen by 180 beams in each of 4 directions."""
    path = tmp_path_factory.mktemp("logs") / "round room.log.gz"
    lines = []
    for k in range(4):
        readings = " ".join(["2.0"] * 179 + ["81.83"])
        pose = f"0.01 0.02 {k * np.pi / 2}"
        lines += [f"ODOM {pose} 0 0 0 {k} host {k}", f"FLASER 180 {readings} {pose} {pose} {k} host {k}"]
    path.write_bytes(gzip.compress("\n".join(lines).encode() + b"\n"))
    return path


def test_info_says_what_a_log_holds(run, log):
    status, out, err = run("info", log)
    assert (status, err) == (0, "")
    assert "4 scans of 180 beams over 179.0°, 3.0 s" in out
    assert "716 readings measured, 4 without return, 0 invalid" in out
    assert "trajectory scan:" in out
    assert "trajectory wheel:" in out


def test_info_as_json_is_one_object_and_nothing_else(run, log):
    status, out, err = run("info", log, "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert (facts["scans"], facts["beams"], facts["duration_s"]) == (4, 180, 3.0)
    assert facts["readings"] == {"measured": 716, "no_return": 4, "invalid": 0}
    assert [trajectory["name"] for trajectory in facts["trajectories"]] == ["scan", "wheel"]


def test_info_lists_the_topics_of_a_recording_and_map_takes_one(run, tmp_path):
    at = 1_700_000_000 * recorded.SECOND
    said = [recorded.scan(at + i, [2.0, 3.0], "/front", "front") for i in range(3)]
    said += [recorded.scan(at + i * recorded.SECOND, [4.0], "/rear", "rear") for i in range(2)]
    path = recorded.write_bag(tmp_path / "run.bag", said)
    status, out, _ = run("info", path)
    assert status == 0
    assert "from 2023-11-14 22:13:20 UTC" in out
    assert "* /front: 3 × sensor_msgs/LaserScan, 2 beams over 5.7°" in out
    assert "  /rear: 2 × sensor_msgs/LaserScan, 1 beam over 0.0°, 1.0 Hz, frame rear" in out
    assert "the file holds no poses" in out.lower()
    rear = json.loads(run("info", path, "--topic", "/rear", "--json").out)
    assert (rear["scans"], rear["topics"][1]["chosen"]) == (2, True)
    assert json.loads(run("map", path, "--topic", "/rear", "--json").out)["scans"] == 2
    status, _, err = run("map", path, "--topic", "/left")
    assert (status, err.count("\n")) == (2, 1)
    assert "'/left'; it has /front, /rear" in err


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


def test_map_takes_the_run_away(run, log, tmp_path):
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


def test_map_for_people_says_what_was_written(run, log, tmp_path):
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


def state_counts(run: Callable[..., Outcome], *arguments: object) -> dict[str, Any]:
    status, out, err = run("map", *arguments, "--json")
    assert status == 0, err
    facts: dict[str, Any] = json.loads(out)
    return facts


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


def test_mapping_goes_on_from_a_map_file(run, log, tmp_path):
    known = state_counts(run, log, "--out", tmp_path / "known", "--resolution", 0.1)
    again = state_counts(run, log, "--prior", tmp_path / "known.yaml", "--hit", 0, "--miss", 0)
    same = ("resolution", "rows", "cols", "origin", "occupied", "free", "unknown")
    assert {name: again[name] for name in same} == {name: known[name] for name in same}
    status, out, err = run("map", log, "--prior", tmp_path / "known.yaml", "--resolution", 0.05)
    assert (status, out) == (2, "")
    assert "must be the same" in err
    status, out, err = run("map", log, "--prior", tmp_path / "gone.yaml")
    assert (status, out) == (2, "")
    assert "There is no file 'gone.yaml'" in err


def test_a_ring_of_sonars_maps_from_its_folder(run, tmp_path):
    (tmp_path / "measurement.txt").write_text("".join(f"{200 * t} 2000 2000 2000 5110\n" for t in range(20)))
    (tmp_path / "poses.txt").write_text("".join(f"{200 * t} {10 * t} 0 0\n" for t in range(20)))
    cones = state_counts(run, tmp_path)
    assert cones["free"] > 2 * state_counts(run, tmp_path, "--model", "fixed-increments")["free"]
    assert cones["cells_updated"] > state_counts(run, tmp_path, "--opening", 0.1)["cells_updated"]


def test_the_doctor_says_what_is_wrong(run, tmp_path):
    # A robot that turns in a square room, whose laser is said to look backwards.
    lines = ["PARAM robot_frontlaser_offset 0.0"]
    for t in range(40):
        yaw = 0.15 * t
        angles = yaw + np.radians(np.arange(180) - 90.0) + np.pi
        ranges = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
        pose = f"{0.01 * t} 0 {yaw}"
        readings = " ".join(f"{r:.3f}" for r in ranges)
        lines.append(f"FLASER 180 {readings} {pose} {pose} {0.2 * t:.3f} robot {0.2 * t:.3f}")
    path = tmp_path / "backwards.log"
    path.write_text("\n".join(lines) + "\n")
    facts = json.loads(run("doctor", path, "--json").out)
    assert facts["log"] == "backwards.log"
    status, out, _ = run("doctor", path)
    assert status == 0
    assert f"{len(facts['findings'])} finding" in out
    for finding in facts["findings"]:
        assert finding["sentence"] in out
        assert finding["advice"] in out
    short = tmp_path / "short.log"
    short.write_text(lines[1] + "\n")
    status, out, err = run("doctor", short)
    assert (status, out) == (2, "")
    assert "too short to judge" in err


def test_two_maps_are_compared(run, log):
    same = json.loads(run("compare", log, "--json").out)
    assert same["changed"] == []
    other = json.loads(run("compare", log, "--other", "update=per-scan", "--other", "clamp=off", "--json").out)
    assert other["changed"]
    assert other["same"] <= same["same"] + sum(change["cells"] for change in other["changed"])
    poses = json.loads(run("compare", log, "--other-trajectory", "wheel", "--json").out)
    assert poses["changed"] != other["changed"]
    assert "cells:" in run("compare", log, "--other", "log_odds_miss=-0.1").out
    for bad, words in (
        ("speed=3", "--other needs NAME=VALUE"),
        ("window", "--other needs"),
        ("window=wide", "Hit window"),
    ):
        status, out, err = run("compare", log, "--other", bad)
        assert (status, out) == (2, "")
        assert words in err


def test_the_mount_moves_the_map(run, log):
    plain, moved = state_counts(run, log), state_counts(run, log, "--mount", "-1.5,0,3.14159")
    # Whole tiles of 3.2 m on each side of the origin: the room ends at 2 m, or at 1.5 m + 2 m behind the robot.
    assert (plain["rows"], plain["cols"]) == (128, 128)
    assert (moved["rows"], moved["cols"]) == (256, 256)


BAD_OPTIONS = {
    "resolution of 0": (["--resolution", "0"], "Resolution (resolution) must be between 0.01 and 1 m"),
    "resolution of nan": (["--resolution", "nan"], "Resolution (resolution) must be a finite number"),
    "unknown model": (["--model", "neural"], "must be one of " + ", ".join(MODELS) + ", not 'neural'"),
    "hit below 0": (["--hit", "-1"], "Hit increment (log_odds_hit) must be between 0 and 3"),
    "clamp upside down": (["--log-odds-min", "0", "--log-odds-max", "0"], "The lower clamp must lie below"),
    "unknown trajectory": (["--trajectory", "slam"], "The log has no trajectory 'slam'; it has 'scan', 'wheel'."),
    "prior of a word": (["--prior", "much"], "There is no file 'much'"),
    "prior out of range": (["--prior", "9"], "Prior ℓ₀ (log_odds_prior) must be between -2 and 2"),
    "mount of two numbers": (["--mount", "1,2"], "--mount needs three numbers, X,Y,YAW"),
    "mount of words": (["--mount", "a,b,c"], "--mount needs three numbers"),
    "mount out of range": (["--mount", "9,0,0"], "Mount forward (mount_x) must be between -2 and 2 m"),
    "unknown mode": (["--mode", "colour"], "--mode must be trinary, scale or raw, not 'colour'."),
}


@pytest.mark.parametrize("case", BAD_OPTIONS)
def test_a_bad_option_is_one_sentence_and_status_2(run, log, case):
    options, words = BAD_OPTIONS[case]
    status, out, err = run("map", log, *options)
    assert (status, out) == (2, "")
    assert words in err
    assert err.startswith("gridbloom: ")
    assert err.count("\n") == 1


def test_a_word_that_is_no_number_and_an_unknown_option_are_refused(run, log):
    for options in (["--resolution", "fine"], ["--colour", "red"], ["--clamp=maybe"]):
        status, out, err = run("map", log, *options)
        assert (status, out) == (2, "")
        assert "Traceback" not in err


@pytest.mark.parametrize("command", ["info", "map"])
def test_a_bad_log_is_one_sentence_with_its_path_and_status_2(run, tmp_path, command):
    bad = tmp_path / "bad.log"
    bad.write_text("FLASER 2 1.0\n")
    status, out, err = run(command, bad, "--json")
    assert (status, out) == (2, "")
    assert err == (
        f"gridbloom: {bad}: Line 1: this FLASER line ends early: it states 2 beams and needs 11 fields, but has 3.\n"
    )
    assert (
        run(command, tmp_path / "gone.log").err == f"gridbloom: {tmp_path / 'gone.log'}: There is no file 'gone.log'.\n"
    )


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


def test_bench_measures_each_kind_of_update(run, log):
    status, out, err = run("bench", "map", log, "--resolution", 0.1, "--max-range", 5, "--repeats", 2, "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert (facts["scans"], facts["beams"], facts["resolution"], facts["range_max"]) == (4, 180, 0.1, 5.0)
    assert facts["per_beam_ms"] > 0.0
    assert facts["per_scan_ms"] > 0.0
    assert facts["cells"] == state_counts(run, log, "--resolution", 0.1, "--max-range", 5)["cells_updated"]
    assert facts["per_scan_cells"] < facts["cells"]
    assert "per beam" in run("bench", "map", log, "--repeats", 1).out
    assert run("bench", "map", log, "--repeats", 0).status == 2


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


def test_view_of_a_bad_map_is_one_sentence_and_status_2(run, tmp_path):
    bad = tmp_path / "m.yaml"
    bad.write_text(
        "image: ../secret.pgm\nresolution: 1\norigin: [0,0,0]\nnegate: 0\noccupied_thresh: 1\nfree_thresh: 0\n"
    )
    status, out, err = run("view", bad)
    assert (status, out) == (2, "")
    assert err == f"gridbloom: {bad}: The map's yaml names an image outside its own folder: '../secret.pgm'.\n"
    assert run("view", bad, "--width", 0).status == 2


def test_serve_refuses_what_the_settings_refuse(run, tmp_path):
    for options, words in ((["--port", "70000"], "port"), (["--logs-dir", tmp_path / "gone"], "is no folder")):
        status, out, err = run("serve", *options)
        assert (status, out) == (2, "")
        assert words in err
        assert "Traceback" not in err


def test_serve_gives_its_options_to_the_service(run, tmp_path, monkeypatch):
    given: list[Settings] = []
    monkeypatch.setattr("server.serving.run", given.append)
    monkeypatch.setenv("GRIDBLOOM_HOST", "::1")
    assert run("serve", "--port", 0, "--data-dir", tmp_path / "data", "--logs-dir", tmp_path).status == 0
    (settings,) = given
    assert (settings.host, settings.port, settings.data_dir, settings.logs_dir) == (
        "::1",
        0,
        tmp_path / "data",
        tmp_path,
    )


def test_help_imports_neither_numba_nor_the_web_server():
    program = (
        "import sys; sys.argv = ['gridbloom', '--help']\n"
        "from server.cli import main\n"
        "try: main()\n"
        "except SystemExit as ended: print(ended.code)\n"
        "print([name for name in ('numba', 'fastapi', 'viser', 'PIL', 'scipy', 'pydantic') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.endswith("0\n[]\n")
    assert "bench" in done.stdout


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs a pseudo-terminal")
def test_a_terminal_sees_progress_and_standard_output_stays_clean(log):
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
