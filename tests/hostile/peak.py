"""Open logs in a process of its own, and report the result of each and the process's peak memory.

``python -m tests.hostile.peak LOG_BYTES CHUNK_BYTES FILE…`` prints a line of JSON before the first file and after each.
"""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

from mapper.core.errors import MapperError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs import open_log


def main() -> None:
    log_bytes, chunk_bytes = map(int, sys.argv[1:3])
    limits = replace(DEFAULT_LIMITS, max_unpacked_bytes=log_bytes, max_chunk_bytes=chunk_bytes)
    _say("")
    for name in sys.argv[3:]:
        code = "a log"
        try:
            open_log(Path(name), limits=limits)
        except MapperError as error:
            code = error.code
        _say(code)


def _say(code: str) -> None:
    # Not resource's ru_maxrss, which begins at what the parent held when it made this process.
    most = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert most
    print(json.dumps({"code": code, "bytes": 1024 * int(most[1])}), flush=True)


if __name__ == "__main__":
    main()
