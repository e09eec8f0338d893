"""The logs in memory, with a limit in bytes: the least recently used are removed first."""

from __future__ import annotations

from collections import OrderedDict

from mapper.sensors.scan import ScanLog
from server.library.packs.log import nbytes


class LogCache:
    """Keeps up to ``max_bytes`` of logs, and always the newest one, so that all its sessions share it.

    Used from the event loop only.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._logs: OrderedDict[str, ScanLog] = OrderedDict()
        self.bytes = 0

    def get(self, log_id: str) -> ScanLog | None:
        """Return the log and mark it as just used; None if it is not cached."""
        log = self._logs.get(log_id)
        if log is not None:
            self._logs.move_to_end(log_id)
        return log

    def put(self, log_id: str, log: ScanLog) -> None:
        """Cache ``log``, removing the least recently used ones until it fits."""
        self.drop(log_id)
        self._logs[log_id] = log
        self.bytes += nbytes(log)
        while self.bytes > self._max_bytes and len(self._logs) > 1:
            oldest = next(iter(self._logs))
            self.drop(oldest)

    def drop(self, log_id: str) -> None:
        """Remove a log, if it is cached."""
        log = self._logs.pop(log_id, None)
        if log is not None:
            self.bytes -= nbytes(log)
