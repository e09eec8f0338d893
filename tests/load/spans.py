"""Processor time of the parts of a program: functions are replaced by versions that count the time spent in them."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack, contextmanager
from functools import wraps
from typing import Any
from unittest.mock import patch


class Spans:
    """Exclusive processor time by name: time in a part within another part counts for the inner one only."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.calls: defaultdict[str, int] = defaultdict(int)
        self._local = threading.local()
        self._patches = ExitStack()

    @contextmanager
    def span(self, name: str) -> Any:
        """Count the thread's processor time in the block for ``name``."""
        within: list[float] = self._local.__dict__.setdefault("within", [])
        within.append(0.0)
        began = time.thread_time()
        try:
            yield
        finally:
            lasted = time.thread_time() - began
            self.seconds[name] += lasted - within.pop()
            self.calls[name] += 1
            if within:
                within[-1] += lasted

    def count(self, name: str, owner: Any, attribute: str) -> None:
        """Count the calls of a function or a method for ``name``, until :meth:`close`."""
        function: Callable[..., Any] = getattr(owner, attribute)

        @wraps(function)
        def counted(*arguments: Any, **named: Any) -> Any:
            with self.span(name):
                return function(*arguments, **named)

        self._patches.enter_context(patch.object(owner, attribute, counted))

    def reset(self) -> None:
        """Forget what was counted."""
        self.seconds.clear()
        self.calls.clear()

    def close(self) -> None:
        """Put the functions back."""
        self._patches.close()
