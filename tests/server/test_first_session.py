"""The first session of a service imports numba, without blocking the event loop."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.marks import also_long_rows

ROOT = Path(__file__).parents[2]
PROGRAM = """
import asyncio, sys
from pathlib import Path
from tests.server.service import running, settings_for, until

seen = []

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "numba":
            try:
                asyncio.get_running_loop()
            except RuntimeError:
                seen.append("on a worker thread")
            else:
                seen.append("on the event loop")

sys.meta_path.insert(0, Watch())
with running(settings_for(Path(sys.argv[1]))) as service:
    seen.append("ready")
    session = service.begin(kind=sys.argv[2], **{sys.argv[3]: sys.argv[4]})
    assert service.http.get(f"/api/sessions/{session}/map.pgm").status_code == 200
    from server.stream.commands import StepCommand
    sessions = service.state.sessions
    sessions.loop.call_soon_threadsafe(sessions.get(session).enqueue, StepCommand(5))
    until(lambda: sessions.get(session).model.grid.observed.any())
print(seen)
"""


@pytest.mark.parametrize(
    ("kind", "key", "name"), [("simulation", "world", "office"), *also_long_rows(("log", "log", "sample-office"))]
)
def test_a_worker_thread_imports_numba(kind: str, key: str, name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path), kind, key, name],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.endswith("\n['ready', 'on a worker thread']\n"), done.stderr
