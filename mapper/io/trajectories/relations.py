"""Known relations between places: the ground truth of the Freiburg SLAM benchmark.

Source: the benchmark's page on its metric (Kümmerle et al. 2009): a line ``t1 t2 x y z roll pitch yaw`` for each
relation, seconds, metres, radians; lines that start with ``#`` are comments.
"""

from __future__ import annotations

import os
from array import array
from pathlib import Path

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.evaluation.relations import Relations
from mapper.io.logs.text import fields
from mapper.io.trajectories.lines import rows, stamp_ns

COLUMNS = "t1 t2 x y z roll pitch yaw"


def read_relations(path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> Relations:
    """Return the relations in a file, plain or compressed, as planar motions: x, y and yaw.

    Raises :class:`ReadError`, naming the line, for a line without eight numbers or with an invalid motion or time, and
    for a file without relations; :class:`LimitError` for one with more lines or bytes than ``limits`` allow.
    """
    stamps, motions = array("q"), array("d")
    for line, tokens in rows(Path(path), limits, "relation", COLUMNS):
        stamps.extend(stamp_ns(token, line, "relation") for token in tokens[:2])
        x, y, _, _, _, yaw = tokens[2:]
        fields.numbers(tokens[2:], line, "relation")
        motions.extend(fields.pose([x, y, yaw], line, "relation", "the relative", limits))
    if not stamps:
        raise ReadError("trajectory.empty", f"The file holds no relations, lines of {COLUMNS}.")
    return Relations(np.array(stamps, dtype=np.int64).reshape(-1, 2), np.array(motions).reshape(-1, 3))
