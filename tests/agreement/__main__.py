"""``python -m tests.agreement``: the table of kernels in all modes, with ten times the examples of ``make test``.

``--examples 1000`` draws more, ``--mode plain`` runs one mode only; what follows goes to pytest, as in
``python -m tests.agreement -k volume``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tests.agreement.modes import MODES, run_table


def main() -> int:
    """Run the table in the modes; return 1 if it does not hold in one of them."""
    parser = argparse.ArgumentParser(prog="python -m tests.agreement", description="Compare kernels with the textbook.")
    parser.add_argument("--examples", type=int, default=120, help="inputs for each kernel (120)")
    parser.add_argument("--mode", action="append", choices=list(MODES), help="one of the modes; all without it")
    options, arguments = parser.parse_known_args()
    failed = []
    with tempfile.TemporaryDirectory() as cache:
        for mode in options.mode or MODES:
            print(f"{mode}:", flush=True)
            if run_table(mode, options.examples, Path(cache), *arguments, capture=False)[0] != 0:
                failed.append(mode)
    print(f"The table does not hold: {', '.join(failed)}." if failed else "The table holds.")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
