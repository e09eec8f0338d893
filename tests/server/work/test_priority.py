"""Threads of lower priority."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import get_native_id

import pytest

from server.work.priority import NICENESS, lower_priority


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a niceness of each thread")
def test_only_the_threads_of_the_pool_have_a_lower_priority() -> None:
    own = os.getpriority(os.PRIO_PROCESS, get_native_id())

    def niceness() -> int:
        return os.getpriority(os.PRIO_PROCESS, get_native_id())

    with ThreadPoolExecutor(1, initializer=lower_priority) as pool:
        assert pool.submit(niceness).result() == min(own + NICENESS, 19)
    assert niceness() == own
