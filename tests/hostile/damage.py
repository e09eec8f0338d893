"""Ways to damage a file, and the allowed results: something usable, or one of our own errors.

With ``GRIDBLOOM_FUZZ=10000``, as in ``make test-long``, each format meets 10,000 damaged files, every prefix and every
place; without it, a seeded part of them. Tests that do so are marked ``sampled``.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.random import Generator

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.grid import OccupancyGrid
from mapper.io.logs import open_log
from mapper.io.logs.summary import summarise
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog

ALL = "GRIDBLOOM_FUZZ" in os.environ
ROUNDS = int(os.environ.get("GRIDBLOOM_FUZZ", "60"))  #: damaged files of each format

COARSE = MappingConfig(resolution=1.0)
FEW_CELLS = replace(DEFAULT_LIMITS, max_cells=1 << 20)

#: Words that do harm in the place of a number or a name.
WORDS = (
    "nan", "-nan", "inf", "-inf", "1e999", "-1e999", "1e308", "1e-400", "-1", "-0.0", "0", "999999999", "2147483648",
    "4294967295", "18446744073709551616", "9" * 400, "1_000", "0x10", "1,5", "+1", "1e5", "٣", "½", "−1", "",
    "#", "\0", "\ufeff", "FLASER", "ODOM", "PARAM", "Laser", "stamp,x,y,theta,ranges", "../../etc/passwd", "<script>",
    "\u202e", "x" * 5000, "true", "[]", "{}", "&a", "*a", "!!python/object/apply:os.getcwd", "1:30",
)  # fmt: skip


def flipped(rng: Generator, data: bytes) -> bytes:
    """Return ``data`` with one to four bits flipped or bytes replaced."""
    damaged = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, len(data)))
        damaged[at] = int(rng.integers(0, 256)) if rng.random() < 0.5 else damaged[at] ^ (1 << int(rng.integers(0, 8)))
    return bytes(damaged)


def mangled(rng: Generator, text: str, separator: str = " ") -> bytes:
    """Return ``text`` with one to three mistakes that a program or a person makes with lines and their words."""
    lines = text.split("\n")
    ends = "\n"
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(0, len(lines)))
        words = lines[at].split(separator)
        word = int(rng.integers(0, len(words)))
        match int(rng.integers(0, 11)):
            case 0:
                del words[word]
            case 1 | 2 | 3:
                words[word] = WORDS[int(rng.integers(0, len(WORDS)))]
            case 4:
                words.insert(word, words[int(rng.integers(0, len(words)))])
            case 5:
                words[word] = f"-{words[word]}"
            case 6:
                words[word] += "0" * int(rng.integers(1, 12))
            case 7:
                lines.insert(at, lines[int(rng.integers(0, len(lines)))])
            case 8:
                other = int(rng.integers(0, len(lines)))
                lines[at], lines[other] = lines[other], lines[at]
            case 9:
                ends = ("\r\n", "\r", "\n\n", "\n\0")[int(rng.integers(0, 4))]
            case _:
                words = words[:word]
        if lines:
            lines[at % len(lines)] = separator.join(words)
    return ends.join(lines).encode("utf-8")


def opened(path: Path, data: bytes, limits: Limits = DEFAULT_LIMITS) -> ScanLog | MapperError:
    """Return the log that ``data`` is, written to ``path``, or the error in one sentence; else there is a defect."""
    path.write_bytes(data)
    return opened_from(path, limits)


def opened_from(path: Path, limits: Limits = DEFAULT_LIMITS) -> ScanLog | MapperError:
    """Return the log at ``path``, which is one that can be used, or the error in one sentence."""
    refusal = None
    try:
        log = open_log(path, limits=limits)
    except MapperError as error:
        refusal = error
    if refusal is not None:
        check_sentence(refusal, path, "log")
        return refusal
    check_usable(log)
    return log


def check_sentence(error: MapperError, path: Path, *areas: str) -> None:
    """Check that an error is one sentence, of a known kind, that does not tell where the file lies."""
    assert isinstance(error, ReadError | LimitError), repr(error)
    assert error.code.split(".")[0] in areas, error.code
    assert error.message.endswith("."), error.message
    assert len(error.message) < 1500, error.message
    assert "\n" not in error.message, error.message
    assert str(path.parent) not in error.message, error.message
    error.message.encode("utf-8")  # it goes out as JSON


def check_usable(log: ScanLog) -> None:
    """Check that everything that is done with a log can be done with this one: figures, JSON and a map."""
    assert log.n_scans >= 1
    assert not np.any(log.ranges <= 0.0)
    assert all(np.isfinite(trajectory.poses).all() for trajectory in log.trajectories.values())
    assert len(log.notes) < 60
    summary = asdict(summarise(log))
    del summary["range_max"]  # which may be infinite
    json.dumps(summary, allow_nan=False, ensure_ascii=False).encode("utf-8")
    refusal = None
    try:
        grid = OccupancyGrid(geometry_for(log, COARSE, limits=FEW_CELLS))
        integrate_log(grid, log, COARSE)
    except MapperError as error:
        refusal = error
    if refusal is None:
        assert np.isfinite(grid.log_odds).all()
    else:
        assert isinstance(refusal, LimitError), repr(refusal)
