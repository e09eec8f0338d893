"""Compilation of kernels with numba: without the GIL, cached on disk for each package.

numba validates a cache entry by the modification time and size of the function's own file, and misses changes to
functions called from other files. So each kernel package has a cache folder named after a hash of its source files and
of the kernel packages that it imports. Editing a kernel recompiles only the packages that depend on it.

Importing this module imports numba. :mod:`mapper.core.jit` defers that to the first call of a kernel.
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

# If the folder is not writable, numba falls back on a cache folder of the user.
_BASE = Path(config.CACHE_DIR or _ROOT / "__pycache__")  # type: ignore[attr-defined] # numba makes its settings at run time


def _start_without_blas() -> None:
    """Load numba's BLAS lookup in such a way that it does not find SciPy.

    The lookup takes a fifth of the time from process start to the first kernel, and no kernel multiplies matrices.
    SciPy itself is not affected.
    """
    with hidden_modules("scipy.linalg"):
        importlib.import_module("numba.np.arraymath")


def _imported_by(packages: frozenset[str]) -> frozenset[str]:
    """Return these kernel packages and all packages that they import, directly or indirectly."""
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
    """Return numba's dispatcher of a function of ``mapper.<package>.kernels``; it compiles on the first call.

    If NUMBA_DISABLE_JIT is set, return the function itself. Not thread-safe.
    """
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    # numba reads the setting when the decorator is applied.
    config.CACHE_DIR = str(cache_folder(function.__module__.split(".")[1]))  # type: ignore[attr-defined]
    try:
        return njit(nogil=True, cache=True)(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]


_start_without_blas()
