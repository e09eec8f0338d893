"""Errors of options and logs are one sentence, with exit status 2."""

from __future__ import annotations

import gzip

import pytest

from mapper.mapping.parameters import MODELS

BAD_OPTIONS = {
    "resolution of 0": (["--resolution", "0"], "Resolution (resolution) must be between 0.01 and 1 m"),
    "resolution of nan": (["--resolution", "nan"], "Resolution (resolution) must be a finite number"),
    "unknown model": (["--model", "neural"], "must be one of " + ", ".join(MODELS) + ", not 'neural'"),
    "hit below 0": (["--hit", "-1"], "Hit increment (log_odds_hit) must be between 0 and 3"),
    "clamp upside down": (["--log-odds-min", "0", "--log-odds-max", "0"], "The lower clamp must be below"),
    "unknown trajectory": (["--trajectory", "slam"], "The log has no trajectory 'slam'; it has 'scan', 'wheel'."),
    "prior of a word": (["--prior", "much"], "There is no file 'much'"),
    "prior out of range": (["--prior", "9"], "Prior ℓ₀ (log_odds_prior) must be between -2 and 2"),
    "mount of two numbers": (["--mount", "1,2"], "--mount needs three numbers, X,Y,YAW"),
    "mount of words": (["--mount", "a,b,c"], "--mount needs three numbers"),
    "mount out of range": (["--mount", "9,0,0"], "Mount forward (mount_x) must be between -2 and 2 m"),
    "number of a word": (["--resolution", "fine"], "Resolution (resolution) must be a finite number, not 'fine'."),
    "more scans than there are": (["--scans", "5"], "The log has no scans 0 to 5; it has 4."),
    "unknown mode": (["--mode", "colour"], "--mode must be trinary, scale or raw, not 'colour'."),
}


@pytest.mark.parametrize("case", BAD_OPTIONS)
def test_a_bad_option_prints_one_sentence_and_exits_with_status_2(run, log, case):
    options, words = BAD_OPTIONS[case]
    status, out, err = run("map", log, *options)
    assert (status, out) == (2, "")
    assert words in err
    assert err.startswith("gridbloom: ")
    assert err.count("\n") == 1


def test_an_unknown_option_and_a_value_for_a_switch_are_refused(run, log):
    for options in (["--colour", "red"], ["--clamp=maybe"]):
        status, out, err = run("map", log, *options)
        assert (status, out) == (2, "")
        assert "Traceback" not in err


@pytest.mark.parametrize("command", ["info", "map"])
def test_a_bad_log_prints_one_sentence_with_its_path_and_exits_with_status_2(run, tmp_path, command):
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


@pytest.mark.parametrize(
    "command", [("costmap",), ("view",), ("path", "--from", "0,0", "--to", "1,1"), ("terrain",)], ids=lambda one: one[0]
)
def test_a_log_in_place_of_a_map_or_a_cloud_is_told_as_such(run, log, tmp_path, command):
    name, *options = command
    out = [] if name in ("view", "path") else ["--out", tmp_path / "out"]
    status, printed, err = run(name, log, *options, *out)
    assert (status, printed) == (2, "")
    assert (
        f"{log}: This is a log, and a {'file of a point cloud' if name == 'terrain' else 'map'} is needed here" in err
    )
    assert err.count("\n") == 1


def test_a_large_log_in_place_of_a_map_is_told_as_such_and_other_files_as_before(run, log, tmp_path):
    large = tmp_path / "large.log"
    large.write_bytes(gzip.decompress(log.read_bytes()) * 100)
    status, _, err = run("view", large)
    assert status == 2
    assert f"`gridbloom map {large} --out out/map` makes one" in err
    (tmp_path / "other.yaml").write_text("a: 1\n")
    assert "lacks the key 'image'" in run("view", tmp_path / "other.yaml").err
