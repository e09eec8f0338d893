"""Faster imports, for the start of the service, and imports on a thread for later ones."""

from __future__ import annotations

import asyncio
import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module

from mapper.core.lazy_imports import hidden_modules

# Other packages import these if they are installed, and the service does not use them.
UNUSED_BY_ROUTES = ("pydantic.v1",)  #: FastAPI would look for its models, even when a route is first requested
UNUSED = ("rich", "colorama", *UNUSED_BY_ROUTES)  #: structlog would format tracebacks, and colour Windows terminals


@contextmanager
def fast_imports() -> Iterator[None]:
    """Run the block, which imports, without the modules :data:`UNUSED` and without Python's cyclic garbage collector.

    Only for the thread of the start-up. Imported objects exist until the process ends. The collector would traverse all
    of them again and again, which takes an eighth of the processor time of the service's start. Afterwards it ignores
    them (``gc.freeze``).
    """
    gc.disable()
    try:
        with hidden_modules(*UNUSED):
            yield
    finally:
        gc.freeze()
        gc.enable()


async def imported(*names: str) -> None:
    """Import missing modules on a thread.

    An import takes up to a second, which would block the event loop. A following import statement finds them.
    """
    for name in names:
        spec = getattr(sys.modules.get(name), "__spec__", None)
        if spec is None or getattr(spec, "_initializing", False):  # another thread imports it; a statement would wait
            await asyncio.to_thread(import_module, name)
