"""``gridbloom info --report``, and where the command says that there is one."""

from __future__ import annotations

import json

from server.cli.logs.info import REPORT


def test_the_report_of_a_log_is_written_and_announced(run, log, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    outcome = run("info", log, "--report")
    assert outcome.status == 0
    assert f"wrote {REPORT}" in outcome.out
    facts = json.loads((tmp_path / REPORT).read_text())
    assert facts["format"] == "CARMEN FLASER"
    assert "round" not in json.dumps(facts)


def test_a_log_that_is_not_read_tells_how_to_report_it(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    unknown = tmp_path / "a.log"
    unknown.write_text("what is this?\n")
    outcome = run("map", unknown)
    assert outcome.status == 2
    assert "info LOG --report" in outcome.err
    assert "info LOG --report" not in run("map", tmp_path / "missing.log").err
    assert run("info", unknown, "--report").status == 0
    assert json.loads((tmp_path / REPORT).read_text())["error"]["code"] == "log.unknown_format"
    assert run("info", tmp_path / "missing.log", "--report").status == 2
