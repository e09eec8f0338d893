"""The cache of compiled functions: one folder for each package and text of kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]


def cache_folders(checkout: Path, cache: Path) -> dict[str, Path]:
    """The cache folder of each package of kernels in a checkout."""
    program = "from mapper.core.jit import cache_folder; print(*map(cache_folder, ('grid', 'mapping', 'simulation')))"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=checkout, env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return dict(zip(("grid", "mapping", "simulation"), map(Path, done.stdout.split()), strict=True))


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    shutil.copytree(CHECKOUT / "mapper", tmp_path / "mapper", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def edited(checkout: Path, file: str) -> set[str]:
    """Return the packages whose cache folder changes when a comment is added to a file."""
    cache = checkout / "cache"
    before = cache_folders(checkout, cache)
    assert before == cache_folders(checkout, cache)
    assert {folder.parent for folder in before.values()} == {cache}
    with (checkout / "mapper" / file).open("a") as text:
        text.write("# edited\n")
    after = cache_folders(checkout, cache)
    return {name for name in before if before[name] != after[name]}


def test_an_edited_kernel_changes_the_cache_of_its_own_package_only(checkout: Path) -> None:
    assert edited(checkout, "simulation/kernels/raycast.py") == {"simulation"}
    assert edited(checkout, "mapping/kernels/bresenham.py") == {"mapping"}


def test_an_edited_kernel_changes_the_cache_of_packages_that_import_it(checkout: Path) -> None:
    assert edited(checkout, "grid/kernels/lattice.py") == {"grid", "mapping"}


def test_kernels_are_kept_in_the_folder_of_their_package(tmp_path: Path) -> None:
    program = (
        "import numpy as np; from mapper.grid.kernels.lattice import cell_of; from mapper.core.jit import jit\n"
        "from mapper.simulation.kernels.raycast import nearest_edge as f; f(np.zeros((1, 4)), 0.0, 0.0, np.zeros(2))"
    )
    subprocess.run(
        [sys.executable, "-c", program], cwd=CHECKOUT, env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, check=True
    )
    assert [path.name.rsplit("-", 1)[0] for path in tmp_path.iterdir()] == ["simulation-kernels"]
