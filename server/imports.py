"""Many imports at one time, as at the start of the service, and those that come later."""

from __future__ import annotations

import asyncio
import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

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


async def imported(*names: str) -> None:
    """Import modules on a thread, those that are not there yet.

    An import takes up to a second, for which the event loop has no time. An import statement that follows finds them.
    """
    for name in names:
        spec = getattr(sys.modules.get(name), "__spec__", None)
        if spec is None or getattr(spec, "_initializing", False):  # another thread imports it: a statement would wait
            await asyncio.to_thread(import_module, name)
