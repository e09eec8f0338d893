"""The command, run in this process, and a log for it."""

from __future__ import annotations

import gzip
import sys
from pathlib import Path

import numpy as np
import pytest

from server.cli import main
from tests.server.cli.running import Outcome, Run


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """A function that runs the command in this process."""

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["gridbloom", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return Outcome(int(ended.value.code or 0), *capsys.readouterr())

    return run


@pytest.fixture(scope="session")
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
