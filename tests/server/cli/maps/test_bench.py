"""``bench map``: the time that mapping a log takes."""

from __future__ import annotations

import json

from tests.server.cli.running import state_counts


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
