"""``evaluate``, and ``--tum-trajectory`` of ``map`` and ``doctor``."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.se2 import compose
from tests.server.cli.running import Run, state_counts


def tum(path: Path, stamps: np.ndarray, poses: np.ndarray) -> Path:
    rows = zip(stamps, poses, strict=True)
    text = [f"{t:.6f} {x:.9f} {y:.9f} 0 0 0 {np.sin(a / 2):.12f} {np.cos(a / 2):.12f}\n" for t, (x, y, a) in rows]
    path.write_text("".join(text))
    return path


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    """A way of 20 m, and the same measured by wheels that count 2 % too much, in another frame."""
    stamps = np.arange(21.0)
    way = np.column_stack([stamps, np.zeros(21), np.zeros(21)])
    wheels = compose([3.0, 4.0, 1.0], way * [1.02, 1.0, 1.0])
    return tum(tmp_path / "true.tum", stamps, way), tum(tmp_path / "wheels.tum", stamps, wheels)


def evaluated(run: Run, *arguments: object) -> dict[str, Any]:
    status, out, err = run("evaluate", *arguments, "--json")
    assert status == 0, err
    facts: dict[str, Any] = json.loads(out)
    return facts


def test_two_files(run: Run, pair: tuple[Path, Path]) -> None:
    facts = evaluated(run, *pair)
    assert (facts["pairs"], facts["reference"]["poses"], facts["estimate"]["poses"]) == (21, 21, 21)
    assert facts["alignment"]["how"] == "rigid"
    assert facts["alignment"]["theta"] == pytest.approx(-1.0, abs=1e-6)
    absolute, relative = facts["absolute"]["translation_m"], facts["relative"]["translation_m"]
    # Aligned, the error is 0.02 m for each metre from the middle of the way.
    assert absolute["max"] == pytest.approx(0.2, abs=1e-6)
    assert absolute["rmse"] == pytest.approx(0.02 * np.sqrt((21**2 - 1) / 12), abs=1e-6)
    assert (relative["mean"], relative["std"]) == pytest.approx((0.02, 0.0), abs=1e-6)
    assert facts["relative"]["pairs"] == 20
    assert facts["absolute"]["rotation_rad"]["max"] == pytest.approx(0.0, abs=1e-6)
    assert evaluated(run, *pair, "--align", "scaled")["alignment"]["scale"] == pytest.approx(1 / 1.02, abs=1e-6)
    assert evaluated(run, *pair, "--delta", 5, "--delta-unit", "s", "--all-pairs")["relative"]["pairs"] == 16


def test_the_table(run: Run, pair: tuple[Path, Path]) -> None:
    status, out, err = run("evaluate", *pair)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == f"{pair[1]} against {pair[0]}"
    assert lines[1] == "  21 pairs of poses, of 21 and 21, within 0.01 s"
    assert lines[2].startswith("  aligned by rotation and translation: ")
    assert lines[3] == "  absolute error"
    assert lines[4].split() == ["rmse", "mean", "median", "std", "min", "max", "sse"]
    assert lines[5].split()[:3] == ["translation", "(m)", "0.12111"]
    assert "relative error over 1 m, 20 consecutive pairs" in out


def test_trajectories_of_logs(run: Run, log: Path, tmp_path: Path) -> None:
    facts = evaluated(run, f"{log}:scan", f"{log}:wheel", "--align", "none", "--delta-unit", "frames")
    assert facts["absolute"]["translation_m"]["max"] == 0.0
    assert facts["pairs"] == 4
    with_colon = tmp_path / "a:b.log"
    with_colon.write_text("".join(f"FLASER 2 1.0 1.0 {k} 0 0 {k} 0 0 {k} host {k}\n" for k in range(4)))
    assert evaluated(run, f"{with_colon}:scan", with_colon)["pairs"] == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["true.tum"], "evaluate needs a REFERENCE and an ESTIMATE, or a LOG and --relations FILE."),
        (["true.tum", "gone.tum"], "gone.tum: There is no file 'gone.tum'."),
        (["true.tum:scan", "true.tum"], "true.tum: The file is not a log, so it has no trajectory 'scan'."),
        (["LOG:gps", "true.tum"], "LOG: The log has no trajectory 'gps'; it has 'scan', 'wheel'."),
        (["true.tum", "wheels.tum", "--offset", "100"], "wheels.tum: No stamps of the two trajectories are within"),
        (["true.tum", "wheels.tum", "--delta", "0"], "wheels.tum: Delta must be above 0, not 0."),
        (["true.tum", "--relations", "wheels.tum"], "true.tum: The relations need the log that they belong to"),
        (["LOG", "true.tum", "--relations", "a.relations"], "true.tum: There are 21 poses, and 4 scans in the log"),
    ],
)
def test_bad_input_prints_one_sentence(
    run: Run,
    log: Path,
    pair: tuple[Path, Path],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    message: str,
) -> None:
    folder = pair[0].parent
    monkeypatch.chdir(folder)
    (folder / "a.relations").write_text("0 1 0 0 0 0 0 1.5707963\n")
    (folder / "LOG").write_bytes(log.read_bytes())
    status, out, err = run("evaluate", *arguments, "--json")
    assert (status, out) == (2, "")
    assert err.startswith(f"gridbloom: {message}")
    assert err.count("\n") == 1


def test_relations_of_a_log(run: Run, log: Path, tmp_path: Path) -> None:
    """The robot turns by a quarter from scan to scan; the second relation is 0.1 m off."""
    relations = tmp_path / "a.relations"
    relations.write_text(f"0 1 0 0 0 0 0 {np.pi / 2}\n2 3 0.1 0 0 0 0 {np.pi / 2}\n0 9 0 0 0 0 0 0\n")
    facts = evaluated(run, log, "--relations", relations)
    assert (facts["relations"], facts["all"]["count"]) == (3, 2)
    assert facts["all"]["translation_m"]["mean"] == pytest.approx(0.05)
    assert facts["all"]["rotation_rad"]["max"] == pytest.approx(0.0, abs=1e-9)
    status, out, _ = run("evaluate", f"{log}:wheel", "--relations", relations)
    assert status == 0
    assert f"{log}:wheel over 3 relations" in out
    assert "  1 relation is left out" in out
    assert "published" not in out


def test_relations_of_intel(run: Run, data_file: Callable[[str], Path], tmp_path: Path) -> None:
    """gmapping's poses, given as another log's trajectory and as a TUM file with one line for each scan."""
    intel, relations = data_file("carmen/intel.log.gz"), data_file("relations/intel.relations")
    corrected = data_file("carmen/intel-corrected.log.gz")
    facts = evaluated(run, intel, f"{corrected}:scan", "--relations", relations)
    assert facts["policy"] == "records"
    assert facts["unambiguous"]["count"] == 1050
    assert round(facts["unambiguous"]["translation_m"]["mean"], 4) == 0.0280
    poses = tmp_path / "corrected.tum"
    state_counts(run, corrected, "--tum", poses, "--resolution", 0.5, "--quiet")
    again = evaluated(run, intel, poses, "--relations", relations)
    assert again["all"]["translation_m"] == pytest.approx(facts["all"]["translation_m"], abs=2e-6)
    status, out, _ = run("evaluate", intel, poses, "--relations", relations)
    assert status == 0
    assert "unambiguous, 1050 relations of one message for each stamp" in out
    # Beside what others published.
    rows = {line[4:30].strip(): line for line in out.partition("beside published ones")[2].splitlines()}
    assert "0.0280" in rows["these poses, unambiguous"]
    assert "0.0229" in rows["Cartographer"]
    assert facts["benchmark"] == "intel"


def test_a_map_by_the_poses_of_a_file(run: Run, log: Path, tmp_path: Path) -> None:
    """The log's own poses, written and read again, make its map; other ones are cut to their time."""
    poses = tmp_path / "poses.tum"
    own = state_counts(run, log, "--tum", poses)
    read = state_counts(run, log, "--tum-trajectory", poses)
    assert read["trajectory"] == "tum"
    assert [read[key] for key in ("occupied", "free", "rows", "cols")] == [
        own[key] for key in ("occupied", "free", "rows", "cols")
    ]
    moved = tum(tmp_path / "moved.tum", np.array([0.5, 2.5]), np.array([[5.0, 5.0, 0.0], [5.0, 5.0, 1.0]]))
    cut = state_counts(run, log, "--tum-trajectory", moved)
    assert cut["scans"] == 2
    assert any("2 scans lie before the first or after the last pose" in note for note in cut["notes"])
    assert cut["origin"][0] > own["origin"][0] + 4.0
    assert state_counts(run, log, "--tum-trajectory", poses, "--trajectory", "scan")["trajectory"] == "scan"


def test_a_bad_file_of_poses_is_named(run: Run, log: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.tum"
    bad.write_text("1 2 3\n")
    late = tum(tmp_path / "late.tum", np.array([100.0, 101.0]), np.zeros((2, 3)))
    for command in ("map", "doctor"):
        status, out, err = run(command, log, "--tum-trajectory", bad)
        assert (status, out) == (2, "")
        assert err.startswith(f"gridbloom: {bad}: Line 1 has 3 values, but a TUM line has 8")
        assert run(command, log, "--tum-trajectory", late).err.startswith(
            f"gridbloom: {late}: No scan is within the time"
        )


def test_the_doctor_examines_the_poses_of_a_file(run: Run, tmp_path: Path) -> None:
    """A robot turns in a square room; a file with half the turn makes its map a smear, and its own poses do not."""
    log = tmp_path / "square.log"
    bearings, turns = np.radians(np.arange(180) - 90.0), np.arange(40) * 0.2
    lines = []
    for k, turn in enumerate(turns):
        ahead = bearings + turn
        ranges = 3.0 / np.maximum(np.abs(np.cos(ahead)), np.abs(np.sin(ahead)))
        pose = f"0 0 {turn}"
        lines.append(f"FLASER 180 {' '.join(f'{r:.3f}' for r in ranges)} {pose} {pose} {k} host {k}\n")
    log.write_text("".join(lines))
    half = tum(tmp_path / "half.tum", np.arange(40.0), np.column_stack([np.zeros((40, 2)), turns / 2]))

    def findings(*options: object) -> list[str]:
        status, out, err = run("doctor", log, *options, "--json")
        assert status == 0, err
        return [finding["check"] for finding in json.loads(out)["findings"]]

    assert findings("--tum-trajectory", half, "--trajectory", "scan") == findings()
    assert findings("--tum-trajectory", half) == findings("--tum-trajectory", half, "--trajectory", "tum") != findings()
