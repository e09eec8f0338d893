"""Compiles all kernels in the background, and loads those of the lab, so that the first visitor does not wait."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

COMMAND = (sys.executable, "-P", "-m", "mapper.tools.precompile", "--background")
END_S = 5.0  #: seconds that the process has to end


@contextmanager
def left_out() -> Iterator[None]:
    """Disable the cyclic collector in the block, and exclude the existing objects from it afterwards.

    It would stop all threads for a tenth of a second again and again to traverse the objects loaded by the block.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def load_sessions() -> None:
    """Load what the first session would otherwise load: the code of sessions, the simulator, the lab's kernels.

    Kernels that were never compiled on this machine are left to the session that first uses them.
    """
    with left_out():
        import server.sessions.host  # noqa: PLC0415
        import server.sources.simulation  # noqa: PLC0415, F401
        from mapper.core.compile_cache import cache_folder  # noqa: PLC0415 - numba
        from mapper.core.parallel import single_threaded  # noqa: PLC0415
        from server.parts import stated  # noqa: PLC0415

        list(stated("part", "part_of"))  # imports the parts
        if any(cache_folder("mapping").rglob("*.nbi")):
            from mapper.tools.precompile import precompile_lab  # noqa: PLC0415

            with single_threaded():  # threads would be missing in the workers forked from this process
                precompile_lab()


class WarmUp:
    """A process of the lowest priority that compiles the kernels and stores them on disk, if that is not done.

    The service then loads them in milliseconds, those of the lab as soon as the process has ended. A kernel that is
    needed earlier is compiled by the service itself. The process ends with the service, for whatever reason, because it
    detects the end of its standard input.
    """

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Start the process; if the system has no room for another one, do nothing."""
        quiet = subprocess.DEVNULL
        with suppress(OSError):
            self.process = subprocess.Popen(  # noqa: S603 - nothing of it is anybody's input
                COMMAND, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet
            )
            os.setpriority(os.PRIO_PROCESS, self.process.pid, 19)  # it does so itself, but only after importing
            threading.Thread(target=self._load_after, args=(self.process,), name="loading", daemon=True).start()

    def _load_after(self, compiling: subprocess.Popen[bytes]) -> None:
        if compiling.wait() == 0:
            load_sessions()

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
