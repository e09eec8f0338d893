"""The one decorator of the kernels: compiled by numba, without the GIL, kept on disk.

numba tells whether a kept kernel is still good by the time and size of its own file, and would miss a change in a
function that it calls from another. So what is kept lies in a folder that is named after the text of all kernels.
"""

from __future__ import annotations

import importlib
import sys
from hashlib import sha256
from pathlib import Path

from numba import config, njit

_HERE = Path(__file__).parent
_DIGEST = sha256(b"".join(path.read_bytes() for path in sorted(_HERE.glob("*.py")))).hexdigest()[:16]

# Where the folder cannot be written, numba falls back on one of the user's own.
_BASE = Path(config.CACHE_DIR or _HERE / "__pycache__")  # type: ignore[attr-defined] # numba makes its settings at run time
config.CACHE_DIR = str(_BASE / f"kernels-{_DIGEST}")  # type: ignore[attr-defined]


def _start_without_blas() -> None:
    """Load the part of numba that looks for SciPy's BLAS, and let it find none.

    To look for it takes a fifth of all the time from the start of a process to its first kernel, and no kernel here
    multiplies matrices. SciPy itself stays as it is.
    """
    if "scipy.linalg" in sys.modules:
        return
    sys.modules["scipy.linalg"] = None  # type: ignore[assignment] # which makes an import fail
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        del sys.modules["scipy.linalg"]


_start_without_blas()

jit = njit(nogil=True, cache=True)
