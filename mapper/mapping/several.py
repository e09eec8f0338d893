"""The scans of several sensors of one robot, put into one map in the order of their times."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mapper.core.errors import ConfigError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import CHUNK_READINGS, integrate_log, integrate_order
from mapper.mapping.joint_scans import SensorOrder
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


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
    order = SensorOrder.of_logs(logs)
    step = max(1, CHUNK_READINGS // max(1, *(log.n_beams for log in logs)))
    updated = 0
    for first in range(0, total, step):
        last = min(first + step, total)
        updated += integrate_order(grid, order, config, trajectory, first, last).cells_updated
        if progress is not None:
            progress(last, total)
    return updated
