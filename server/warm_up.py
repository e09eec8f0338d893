"""Compiling all kernels beside the service, so that the first visitor of a page does not wait for it."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress

COMMAND = (sys.executable, "-P", "-m", "mapper.tools.precompile", "--background")
END_S = 5.0  #: seconds that the process has to end


class WarmUp:
    """A process of the lowest priority that compiles the kernels and keeps them on disk; it ends at once if they are.

    The service then loads them in milliseconds. A kernel that is used before it is compiled there is compiled by the
    service itself. The process ends with the service, however that ends: it sees the end of its standard input.
    """

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Begin the process; where the system has no room for another one, nothing happens."""
        quiet = subprocess.DEVNULL
        with suppress(OSError):
            self.process = subprocess.Popen(  # noqa: S603 - nothing of it is anybody's input
                COMMAND, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet
            )
            os.setpriority(os.PRIO_PROCESS, self.process.pid, 19)  # it does so itself, after seconds of imports

    def end(self) -> None:
        """End the process if it runs."""
        if self.process is None:
            return
        self.process.terminate()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.stdin is not None:
            self.process.stdin.close()
