"""What the sessions of each worker use of the budgets of the service, in memory that the workers share."""

from __future__ import annotations

from dataclasses import astuple, fields
from mmap import mmap

import numpy as np
from numpy.typing import NDArray

from server.sessions.use import Use


class SharedUse:
    """A row of numbers for each worker, in memory that processes share which are forked after it was made."""

    def __init__(self, workers: int) -> None:
        columns = len(fields(Use))
        memory = mmap(-1, workers * columns * 8)
        self._rows = np.frombuffer(memory, dtype=np.int64).reshape(workers, columns)

    def of(self, worker: int) -> WorkersUse:
        """Return the view of one worker."""
        return WorkersUse(self._rows, worker)

    def clear(self, worker: int) -> None:
        """Forget what a worker has used, which has ended."""
        self._rows[worker] = 0


class WorkersUse:
    """The rows (workers, columns) as worker ``own`` sees them."""

    def __init__(self, rows: NDArray[np.int64], own: int) -> None:
        self._rows, self._own = rows, own

    def others(self) -> Use:
        """Return what the sessions of the other workers use together."""
        return Use(*(self._rows.sum(axis=0) - self._rows[self._own]).tolist())

    def state(self, own: Use) -> None:
        """State what the sessions of this worker use."""
        self._rows[self._own] = astuple(own)
