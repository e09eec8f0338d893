"""``match``: two scans of a log, or two maps."""

from __future__ import annotations

import json
import math

import numpy as np


def test_two_scans_of_a_log(run, log):
    found = json.loads(run("match", log, "--scans", "0", "1", "--json").out)
    assert found["method"] == "global"
    # The log's poses are true, and without another guess they are where it begins. The room is round, so that nothing
    # tells the angle.
    assert math.dist(found["pose"][:2], found["guess"][:2]) < 0.03
    assert found["degenerate"]
    assert abs(found["unknown_direction"][2]) > 0.3
    assert np.shape(found["covariance"]) == (3, 3)
    assert 0.5 < found["score"] <= 1.0
    same = json.loads(run("match", f"{log}#0", f"{log}#1", "--json").out)
    assert same | {"cpu_seconds": 0} == found | {"cpu_seconds": 0}
    told = run("match", f"{log}#0", f"{log}#1", "--method", "point-to-line", "--guess", "0,0,0").out
    assert "method point_to_line" in told
    assert "pose " in told
    assert "degenerate" in told


def test_two_maps(run, log, tmp_path):
    assert run("map", log, "--out", tmp_path / "map").status == 0
    found = json.loads(run("match", tmp_path / "map.yaml", log, "--window", "0.5,0.2", "--json").out)
    assert found["method"] == "global_field"
    assert math.hypot(*found["pose"][:2]) < 0.03


def test_what_cannot_be_matched_is_refused(run, log, tmp_path):
    for arguments, words in (
        ((log,), "match needs A and B"),
        ((log, log, "--scans", "0", "1"), "not both"),
        ((log, "--scans", "0", "100000"), "no scan 100000"),
        ((f"{log}#0", f"{log}#first"), "not 'first'"),
        ((f"{log}#0", log), "these are one of each"),
        ((log, "--scans", "0", "1", "--guess", "1,2"), "--guess needs three numbers"),
        ((log, "--scans", "0", "1", "--guess", "nan,0,0"), "must be three finite numbers"),
        ((log, "--scans", "0", "1", "--window", "1e9,1"), "between 0 and 50 m"),
        ((log, "--scans", "0", "1", "--method", "icp"), "must be one of global"),
        ((log, "--scans", "0", "1", "--trajectory", "none"), "no trajectory 'none'"),
        ((tmp_path / "none.yaml", log), "none.yaml"),
    ):
        status, out, err = run("match", *arguments)
        assert (status, out) == (2, ""), arguments
        assert words in err
        assert "Traceback" not in err
