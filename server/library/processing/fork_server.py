"""The fork server that processes of jobs are forked from preloads this module: no job waits for the readers' import.

Imported by that process alone (``multiprocessing``'s fork server), which runs no job. It ignores the signals that end
the service: a service manager may send them to all processes of the service, and with it the jobs that run would end as
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
