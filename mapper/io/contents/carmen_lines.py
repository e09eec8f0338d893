"""Contents of a CARMEN log: each first word of lines is a topic; ODOM lines state speeds.

Source: the header that CARMEN's logger writes::

    ODOM x y theta tv rv acceleration  stamp host logger_stamp
"""

from __future__ import annotations

import math
from array import array

import numpy as np

from mapper.core.limits import Limits
from mapper.io.contents.model import Column, Contents, Series, TopicContents
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.names import printable
from mapper.io.logs.text.lines import TextLines

CARMEN_LINE = "CARMEN line"  #: used as the type of a topic
MAX_WORD = 40  #: characters
MOST_WORDS = 200  #: lines with further words are not listed

ODOMETRY = (
    Column("forward", "m/s", "speed"),
    Column("turning", "rad/s", "turn rate"),
    Column("acceleration", "m/s²", "acceleration"),
    Column("x", "m", "position"),
    Column("y", "m", "position"),
    Column("theta", "rad", "heading"),
)


class _Word:
    def __init__(self) -> None:
        self.lines = self.bytes = self.first_ns = self.last_ns = 0


def inspect_carmen(file: Source, limits: Limits, progress: Progress | None) -> Contents:
    """Return the contents of a CARMEN log. Raises the errors of :class:`TextLines`."""
    words: dict[str, _Word] = {}
    stamps, values = array("q"), array("f")
    for _, line in TextLines(file, limits, progress):
        tokens = line.split()
        if not tokens or tokens[0].startswith(b"#"):
            continue
        name = printable(tokens[0][:MAX_WORD].decode("utf-8", "replace"))
        if name not in words and len(words) >= MOST_WORDS:
            continue
        word = words.setdefault(name, _Word())
        word.lines += 1
        word.bytes += len(line) + 1
        stamp_ns = _stamp_ns(tokens)
        if stamp_ns:
            word.first_ns = min(word.first_ns or stamp_ns, stamp_ns)
            word.last_ns = max(word.last_ns, stamp_ns)
        row = _odometry(tokens) if name == "ODOM" and stamp_ns else None
        if row is not None:
            stamps.append(stamp_ns)
            values.extend(row)
    times = np.frombuffer(stamps, dtype=np.int64)
    rows = np.frombuffer(values, dtype=np.float32).reshape(-1, len(ODOMETRY))
    order = np.argsort(times, kind="stable")
    series = (Series("ODOM", CARMEN_LINE, ODOMETRY, times[order], rows[order]),) if len(times) else ()
    return Contents(
        topics=tuple(
            TopicContents(name, CARMEN_LINE, word.lines, word.bytes, word.first_ns, word.last_ns)
            for name, word in sorted(words.items())
        ),
        series=series,
    )


def _stamp_ns(tokens: list[bytes]) -> int:
    """Return the stamp, the third field from the end of a line, 0 if invalid."""
    try:
        seconds = float(tokens[-3]) if len(tokens) > 4 else 0.0
    except ValueError:
        return 0
    return round(seconds * 1e9) if 0.0 < seconds < 9e9 else 0


def _odometry(tokens: list[bytes]) -> list[float] | None:
    """Return the numbers of an ODOM line in the order of ``ODOMETRY``; None for another format."""
    if len(tokens) < 10:
        return None
    try:
        x, y, theta, tv, rv, acceleration = (float(token) for token in tokens[1:7])
    except ValueError:
        return None
    row = [tv, rv, acceleration, x, y, theta]
    return row if all(math.isfinite(value) and abs(value) < 3e38 for value in row) else None
