"""Kernels: compiled with the first call, in one cache folder for each package and text of kernels."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]


def cache_folders(checkout: Path, cache: Path) -> dict[str, Path]:
    """The cache folder of each package of kernels in a checkout."""
    program = (
        "from mapper.core.compile_cache import cache_folder\n"
        "print(*map(cache_folder, ('grid', 'mapping', 'simulation')))"
    )
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


@pytest.mark.long
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


def test_the_first_call_imports_numba_and_makes_one_dispatcher_for_all_threads() -> None:
    program = (
        "import sys; import numpy as np; from threading import Barrier\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from mapper.simulation.kernels.raycast import nearest_edge as f\n"
        "print('numba' in sys.modules, len(f.signatures)); barrier = Barrier(4)\n"
        "def call(_):\n"
        "    barrier.wait(); out = np.zeros(2); f(np.zeros((1, 4)), 3.0, 4.0, out); return id(f.dispatcher)\n"
        "with ThreadPoolExecutor(4) as pool: found = set(pool.map(call, range(4)))\n"
        "print('numba' in sys.modules, len(f.signatures), len(found))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=CHECKOUT, capture_output=True, text=True, check=True)
    assert done.stdout == "False 0\nTrue 1 1\n"
