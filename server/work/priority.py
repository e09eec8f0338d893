"""Threads of lower priority than sessions."""

from __future__ import annotations

import os
import sys
import threading

NICENESS = 10  #: added to the niceness of the service


def lower_priority() -> None:
    """Lower the priority of the calling thread; used as the initializer of a pool's threads."""
    # On Linux each thread has its own niceness. Elsewhere the id could be that of this or another process.
    if sys.platform == "linux":
        thread = threading.get_native_id()
        os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + NICENESS)
