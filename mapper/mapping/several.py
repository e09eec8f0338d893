"""The scans of several sensors of one robot, put into one map in the order of their times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import Bounds, bounds_of_log, integrate_log, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


def stretches(logs: Sequence[ScanLog], count: int | None = None) -> Iterator[tuple[int, int, int]]:
    """Yield (log number, start, stop): the first ``count`` scans (None: all) of all logs in the order of their stamps.

    Scans [start, stop) of one log follow one another without one of another log in between. Within a log the order is
    the file's, also where the time runs backwards; of equal stamps the first log's comes first.
    """
    stamps = [np.maximum.accumulate(log.stamps_ns) for log in logs]
    numbers = np.repeat(np.arange(len(logs)), [log.n_scans for log in logs])
    numbers = numbers[np.argsort(np.concatenate(stamps), kind="stable")][:count]
    edges = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist(), len(numbers)]
    done = [0] * len(logs)
    for first, last in pairwise(edges):
        if first < last:
            number = int(numbers[first])
            yield number, done[number], done[number] + last - first
            done[number] += last - first


def bounds_of_logs(logs: Sequence[ScanLog], config: MappingConfig, trajectory: str | None = None) -> Bounds:
    """Return the least and the greatest x, y (2,), metres, of all that the logs see with ``config``."""
    bounds = [bounds_of_log(log, config, trajectory) for log in logs if log.n_scans]
    return np.min([low for low, _ in bounds], axis=0), np.max([high for _, high in bounds], axis=0)


def integrate_logs(
    grid: OccupancyGrid,
    logs: Sequence[ScanLog],
    config: MappingConfig,
    trajectory: str | None = None,
    count: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Add the first ``count`` scans (None: all) of the logs to ``grid``; return the number of cell updates.

    The logs are those of the sensors of one recording, each with its own mount, and with a trajectory of the same name
    in one frame. ``progress(done, total)`` is called now and then with scans. What falls outside the grid is clipped.
    Raises :class:`ConfigError` for a trajectory that a log lacks, or more scans than there are.
    """
    if len(logs) == 1:
        return integrate_log(grid, logs[0], config, trajectory, 0, count, progress)
    have = sum(log.n_scans for log in logs)
    total = have if count is None else count
    if not 0 <= total <= have:
        raise ConfigError("log.scans", f"The logs have no scans 0 to {total}; they have {have}.")
    updated = done = 0
    for number, start, stop in stretches(logs, total):
        updated += integrate_scans(grid, logs[number], config, trajectory, start, stop).cells_updated
        done += stop - start
        if progress is not None:
            progress(done, total)
    return updated
