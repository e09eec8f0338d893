"""The modes in which numba runs the kernels, and the run of the table in one of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
TABLE = Path(__file__).with_name("test_agreement.py")

#: The environment of each mode: compiled, compiled with a check of each index, and as plain Python.
MODES: dict[str, dict[str, str]] = {
    "compiled": {},
    "bounds": {"NUMBA_BOUNDSCHECK": "1"},
    "plain": {"NUMBA_DISABLE_JIT": "1"},
}


def run_table(mode: str, examples: int, cache: Path, *arguments: str, capture: bool = True) -> tuple[int, str]:
    """Run the table of kernels in a process of its own; return the status of pytest and what it wrote.

    numba's cache does not tell checked code from unchecked code: ``cache`` is that of the mode ``bounds``.
    """
    environment = os.environ | MODES[mode] | {"GRIDBLOOM_EXAMPLES": str(examples)}
    if mode == "bounds":
        environment["NUMBA_CACHE_DIR"] = str(cache)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(TABLE), *arguments]
    done = subprocess.run(command, cwd=CHECKOUT, env=environment, capture_output=capture, text=True, check=False)
    return done.returncode, (done.stdout + done.stderr) if capture else ""
