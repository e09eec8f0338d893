"""Threads of lower priority than those of sessions."""

from __future__ import annotations

import os
import sys
import threading

NICENESS = 10  #: added to that of the service


def lower_priority() -> None:
    """Give the calling thread less of a core that others want too: the initializer of a pool's threads."""
    # On Linux each thread has its own niceness. Elsewhere the id would be that of another process or of this one.
    if sys.platform == "linux":
        thread = threading.get_native_id()
        os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + NICENESS)
