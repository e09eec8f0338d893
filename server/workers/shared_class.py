"""The prepared class of a service with several workers: it belongs to the worker of the visitor who takes it over.

Until then it waits in the worker that its code determines (:func:`server.workers.places.worker_of_class`).
"""

from __future__ import annotations

import os
from mmap import mmap

import numpy as np

from server.workers.places import worker_of_class

_NOBODY = -1


class SharedClass:
    """The worker that has the class, in memory shared by processes that are forked later.

    A pipe holds one byte as long as nobody has the class. Of several processes that read it, one gets the byte.
    """

    def __init__(self, code: str, workers: int) -> None:
        self.code = code
        self._waits_in = worker_of_class(code, workers)
        self._holder = np.frombuffer(mmap(-1, 8), dtype=np.int64)
        self._take, self._give = os.pipe()
        os.set_blocking(self._take, False)
        self._release()

    @property
    def worker(self) -> int:
        """The worker that receives requests with the code."""
        holder = int(self._holder[0])
        return self._waits_in if holder == _NOBODY else holder

    def of(self, worker: int) -> WorkersClass:
        """Return the view of one worker."""
        return WorkersClass(self, worker)

    def take_over(self, worker: int) -> bool:
        """Assign the class to a worker; return False if it was taken before."""
        try:
            os.read(self._take, 1)
        except BlockingIOError:
            return False
        self._holder[0] = worker
        return True

    @property
    def is_taken(self) -> bool:
        """Whether the class was taken over."""
        return int(self._holder[0]) != _NOBODY

    def clear(self, worker: int) -> None:
        """Make the class wait again if its worker has ended."""
        if int(self._holder[0]) == worker:
            self._release()

    def _release(self) -> None:
        self._holder[0] = _NOBODY
        os.write(self._give, b"1")


class WorkersClass:
    """A :class:`SharedClass` as seen by worker ``own``."""

    def __init__(self, shared: SharedClass, own: int) -> None:
        self._shared, self._own = shared, own
        self.code = shared.code

    @property
    def waits_here(self) -> bool:
        """Whether nobody has taken the class over, and requests with its code reach this worker."""
        return not self._shared.is_taken and self._shared.worker == self._own

    def take_over(self) -> bool:
        """Take the class over for a visitor of this worker; return False if it was taken before."""
        return self._shared.take_over(self._own)
