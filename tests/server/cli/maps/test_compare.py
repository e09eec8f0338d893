"""``compare``: two maps compared."""

from __future__ import annotations

import json


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
        ("speed=3", "There is no parameter 'speed'"),
        ("window", "--other needs NAME=VALUE, not 'window'"),
        ("window=wide", "Hit window"),
    ):
        status, out, err = run("compare", log, "--other", bad)
        assert (status, out) == (2, "")
        assert words in err
