"""Preloaded by the fork server of job processes, so that no job waits for the import of the readers.

Imported only by that process (``multiprocessing``'s fork server), which runs no job. It ignores the signals that end
the service: a service manager may send them to all processes of the service, and if it ended, running jobs would end as
if they had failed. It ends when the service has ended.
"""

# ruff: noqa: E402, F401 - nothing interrupts the imports, which are what this module is for

from __future__ import annotations

import signal

for _number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(_number, signal.SIG_IGN)

import mapper.io.logs
import server.library.packs.map_files
import server.library.packs.picture
import server.library.packs.volume_files
import server.library.processing.reading
