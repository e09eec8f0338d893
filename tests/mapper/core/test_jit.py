"""Where compiled kernels are kept: apart for each text of the kernels, so that none outlives a change."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[3]


def kept_by(checkout: Path, cache: Path) -> Path:
    program = "from mapper.grid.kernels.quantise import quantise; from numba import config; print(config.CACHE_DIR)"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=checkout, env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return Path(done.stdout.strip())


def test_a_change_in_any_kernel_moves_the_folder(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    shutil.copytree(CHECKOUT / "mapper", tmp_path / "mapper", ignore=shutil.ignore_patterns("__pycache__"))
    before = kept_by(tmp_path, cache)
    assert before == kept_by(tmp_path, cache)
    assert before.parent == cache
    with (tmp_path / "mapper" / "kernels" / "lattice.py").open("a") as file:
        file.write("# a word more\n")
    assert kept_by(tmp_path, cache) != before
