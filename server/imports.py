"""Many imports at one time, as at the start of the service."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """Run the block, which imports, without Python's cyclic garbage collector; the thread of the start-up only.

    What an import makes stays until the process ends. The collector would look through all of it again and again, at an
    eighth of the processor time of the service's start. What is there in the end it never looks at (``gc.freeze``).
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
