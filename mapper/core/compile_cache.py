"""Compilation of kernels with numba: without the GIL, cached on disk for each package.

numba decides by the time and size of a function's own file whether its cache entry is valid, and misses a change in a
function that it calls from another file. So each package of kernels has a cache folder that is named after the text of
its files and of the packages of kernels that it imports: an edited kernel recompiles these packages only.

Importing this module imports numba. Kernels do so when one of them is first called (:mod:`mapper.core.jit`).
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path

from numba import config, njit
from numba.core.dispatcher import Dispatcher

from mapper.core.lazy_imports import hidden_modules

_ROOT = Path(__file__).parents[1]
_IMPORTED = re.compile(r"^from mapper\.(\w+)\.kernels", re.MULTILINE)

# Where the folder cannot be written, numba falls back on one of the user's own.
_BASE = Path(config.CACHE_DIR or _ROOT / "__pycache__")  # type: ignore[attr-defined] # numba makes its settings at run time


def _start_without_blas() -> None:
    """Load the part of numba that looks for SciPy's BLAS, and let it find none.

    To look for it takes a fifth of all the time from the start of a process to its first kernel, and no kernel here
    multiplies matrices. SciPy itself stays as it is.
    """
    with hidden_modules("scipy.linalg"):
        importlib.import_module("numba.np.arraymath")


def _imported_by(packages: frozenset[str]) -> frozenset[str]:
    """Return these packages of kernels and all that they import, directly or not."""
    texts = (path.read_text() for package in packages for path in (_ROOT / package / "kernels").glob("*.py"))
    modules = packages.union(*(_IMPORTED.findall(text) for text in texts))
    return modules if modules == packages else _imported_by(modules)


@cache
def cache_folder(package: str) -> Path:
    """Return the folder that keeps the compiled functions of ``mapper.<package>.kernels``."""
    paths = [Path(__file__)]
    for name in sorted(_imported_by(frozenset([package]))):
        paths += sorted((_ROOT / name / "kernels").glob("*.py"))
    digest = sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:16]
    return _BASE / f"{package}-kernels-{digest}"


def dispatcher(function: Callable[..., object]) -> Dispatcher:
    """Return numba's dispatcher of a function of ``mapper.<package>.kernels``, which compiles when it is called.

    Where NUMBA_DISABLE_JIT is set it is the function itself. Not for several threads at one time.
    """
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    # numba reads the setting when the decorator is applied.
    config.CACHE_DIR = str(cache_folder(function.__module__.split(".")[1]))  # type: ignore[attr-defined]
    try:
        return njit(nogil=True, cache=True)(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]


_start_without_blas()
