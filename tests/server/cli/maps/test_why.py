"""``why``: the contributions to a cell."""

from __future__ import annotations

import json

import pytest

from mapper.mapping.parameters import MODELS
from tests.server.cli.running import state_counts


def test_every_beam_that_updated_a_cell_is_printed_with_its_increment(run, log):
    # 1.5 m ahead of the first scan, half-way to the left of the last: passed by beams whose readings are 2 m.
    status, out, err = run("why", log, "--at", "1.5,0.02", "--resolution", 0.1, "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert facts["hits"] == 0
    assert {touch["range"] for touch in facts["contributions"]} == {2.0}
    assert len(facts["contributions"]) > 3
    # In closed form: −0.4 each, and never below −2.
    for n, touch in enumerate(facts["contributions"], 1):
        assert touch["log_odds"] == pytest.approx(max(-0.4 * n, -2.0), abs=1e-5)
    assert facts["log_odds"] == pytest.approx(max(-0.4 * len(facts["contributions"]), -2.0), abs=1e-5)
    # The beam straight ahead is the one of 90 among 180, half a degree to either side.
    assert 90 in {touch["beam"] for touch in facts["contributions"] if touch["scan"] == 0}


def test_hits_of_a_wall_and_beams_without_return_are_printed(run, log):
    wall = json.loads(run("why", log, "--at", "2.01,0.05", "--resolution", 0.1, "--json").out)
    assert wall["hits"] > 0
    assert wall["p_occ"] > 0.65
    assert wall["contributions"][0]["increment"] == pytest.approx(0.85)
    free = ["--no-return", "free", "--max-range", 3]
    # The last beam of the first scan, at 89°, is without return: all of its 3 m are free.
    beyond = json.loads(run("why", log, "--at", "0.06,2.6", "--resolution", 0.1, *free, "--json").out)
    assert [(touch["beam"], touch["range"]) for touch in beyond["contributions"] if touch["scan"] == 0] == [(179, None)]
    assert "no return" in run("why", log, "--at", "0.06,2.6", "--resolution", 0.1, *free).out


@pytest.mark.parametrize("model", [model.replace("_", "-") for model in MODELS])
def test_every_model_tells_of_the_map_that_it_makes(run, log, tmp_path, model):
    options = ["--model", model, "--resolution", 0.1, "--scans", 2]
    made = state_counts(run, log, *options, "--mode", "raw", "--out", tmp_path / "m")
    assert made["scans"] == 2
    told = json.loads(run("why", log, "--at", "1.0,0.55", *options, "--json").out)
    assert max(touch["scan"] for touch in told["contributions"]) < 2
    assert told["contributions"][-1]["log_odds"] == told["log_odds"]
    pixels = (tmp_path / "m.pgm").read_bytes().split(b"\n", 3)[3]
    value = pixels[(made["rows"] - 1 - told["row"]) * made["cols"] + told["col"]]
    assert value == pytest.approx(100 * told["p_occ"], abs=1.0)


def test_the_explanation_of_a_cell_includes_the_prior_map(run, log, tmp_path):
    state_counts(run, log, "--resolution", 0.1, "--mode", "raw", "--out", tmp_path / "known")
    told = json.loads(run("why", log, "--at", "1.5,0.02", "--prior", tmp_path / "known.yaml", "--json").out)
    assert told["prior"] == pytest.approx(-1.99, abs=0.02)  # 12 in 100
    assert told["contributions"][0]["log_odds"] == -2.0


def test_missing_cells_and_scans_are_refused(run, log):
    for options, words in (
        (["--at", "50,0"], "is outside the grid"),
        (["--at", "1"], "--at needs two numbers"),
        (["--at", "a,b"], "--at needs two numbers"),
        (["--at", "nan,0"], "lies in no cell"),
        (["--at", "0,0", "--scans", "9"], "there is no map after 9"),
    ):
        status, out, err = run("why", log, *options)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert words in err
