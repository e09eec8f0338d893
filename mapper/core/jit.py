"""Decorator for compiled functions.

Importing numba takes a third of a second of processor time. Processes that compute no map, such as a service without
visitors or a command that prints a log's header, do not import it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import update_wrapper
from threading import Lock
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., object])

_making = Lock()  #: held while a dispatcher is created; two dispatchers of one function would compile it twice


class Kernel:
    """A function that numba compiles on its first call, from Python or from another kernel. Thread-safe.

    ``py_func`` is the Python function.
    """

    def __init__(self, py_func: Callable[..., object]) -> None:
        self.py_func = py_func
        self._dispatcher: Any = None
        update_wrapper(self, py_func)

    def __call__(self, *args: object) -> object:
        """Call the compiled function."""
        dispatcher = self.dispatcher if self._dispatcher is None else self._dispatcher
        return dispatcher(*args)

    @property
    def dispatcher(self) -> Any:  # noqa: ANN401 - numba has no types
        """Numba's dispatcher of the function, or the function itself if NUMBA_DISABLE_JIT is set."""
        with _making:
            if self._dispatcher is None:
                from mapper.core.compile_cache import dispatcher  # noqa: PLC0415 - numba is imported with the first call

                self._dispatcher = dispatcher(self.py_func)
            return self._dispatcher

    @property
    def signatures(self) -> Sequence[object]:
        """The types of arguments for which the function is compiled."""
        return () if self._dispatcher is None else cast("Sequence[object]", self._dispatcher.signatures)

    @property
    def _numba_type_(self) -> object:
        """Type of the function in numba (read by ``numba.typeof``), which lets other kernels call it."""
        return self.dispatcher._numba_type_


def jit(function: F) -> F:
    """Compile a function of a package ``mapper.<package>.kernels`` on its first call and cache it on disk."""
    return cast("F", Kernel(function))
