"""The kernels with index checks, and as plain Python: runs of the table in separate processes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]


@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    ("mode", "examples"),
    [
        pytest.param({"NUMBA_BOUNDSCHECK": "1"}, 60, id="bounds", marks=pytest.mark.long),  # compiles all kernels again
        pytest.param({"NUMBA_DISABLE_JIT": "1"}, 25, id="plain", marks=pytest.mark.long),
        pytest.param({"NUMBA_DISABLE_JIT": "1"}, 2, id="plain, few"),
    ],
)
def test_table_holds(mode: dict[str, str], examples: int, tmp_path: Path) -> None:
    # A cache of its own: numba's cache does not tell checked code from unchecked code.
    environment = os.environ | mode | {"NUMBA_CACHE_DIR": str(tmp_path), "GRIDBLOOM_EXAMPLES": str(examples)}
    table = str(Path(__file__).with_name("test_agreement.py"))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", table]
    done = subprocess.run(command, cwd=CHECKOUT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
