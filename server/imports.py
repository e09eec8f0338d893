"""Many imports at one time, as at the start of the service."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from mapper.core.lazy_imports import hidden_modules

# Other packages import these where they are installed, and the service does not use them.
UNUSED_BY_ROUTES = ("pydantic.v1",)  #: FastAPI would look for its models, also when it is asked for a route first
UNUSED = ("rich", "colorama", *UNUSED_BY_ROUTES)  #: structlog would format tracebacks, and colour Windows terminals


@contextmanager
def fast_imports() -> Iterator[None]:
    """Run the block, which imports, without the modules :data:`UNUSED` and without Python's cyclic garbage collector.

    On the thread of the start-up only. What an import makes stays until the process ends. The collector would look
    through all of it again and again, at an eighth of the processor time of the service's start. What is there in the
    end it never looks at (``gc.freeze``).
    """
    gc.disable()
    try:
        with hidden_modules(*UNUSED):
            yield
    finally:
        gc.freeze()
        gc.enable()
