"""What a worker does with one log of a fleet, in a process with limits."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mapper.core.errors import LimitError
from server.library import job as jobs

DOING = "Reading, examining and mapping this log"
READ, EXAMINED, MAPPED = 0.4, 0.7, 0.95  #: fractions of the job that are done then


@dataclass(frozen=True, slots=True)
class FleetLimits:
    """Limits of one log: seconds of elapsed and of processor time, bytes of address space."""

    timeout_s: float = 1800.0
    cpu_s: float = 1800.0
    memory_bytes: int = 6 << 30


@dataclass(frozen=True, slots=True)
class FleetJob:
    """Read ``source``, examine it, write its map beside ``out`` (.yaml, .pgm) and a picture of it (.png)."""

    source: str
    out: str
    timeout_s: float
    cpu_s: float
    memory_bytes: int

    @property
    def work(self) -> Callable[[FleetJob], dict[str, Any]]:
        """The function that does it."""
        return do_fleet_job

    def time_error(self) -> LimitError:
        """Return the error for a log that takes too long."""
        return jobs.time_error(self.timeout_s, DOING, "fleet")


def do_fleet_job(job: FleetJob) -> dict[str, Any]:
    """Do the job; return what is known of the log, for JSON.

    Raises :class:`mapper.core.errors.MapperError` for a log that is not read or mapped, and for limits.
    """
    return jobs.bounded(job.timeout_s, job.cpu_s, lambda: _done(job), DOING, "fleet")


def _done(job: FleetJob) -> dict[str, Any]:
    from mapper.diagnosis import examine  # noqa: PLC0415 - only the process that does the job needs it
    from mapper.io.logs import open_log  # noqa: PLC0415
    from mapper.io.maps import save_map  # noqa: PLC0415
    from mapper.mapping.integrate import grid_for, integrate_log  # noqa: PLC0415
    from mapper.mapping.parameters import MappingConfig  # noqa: PLC0415
    from server.library.log_picture import write_picture  # noqa: PLC0415

    began = time.process_time()
    out = Path(job.out)
    log = open_log(Path(job.source), progress=lambda done: jobs.note_progress(READ * done))
    jobs.note_progress(READ)
    found = examine(log)
    jobs.note_progress(EXAMINED)
    config = MappingConfig()
    grid = grid_for(log, config)
    integrate_log(grid, log, config)
    save_map(grid, out)
    jobs.note_progress(MAPPED)
    picture = write_picture(log, out.with_name(f"{out.name}.png"))
    geometry = grid.geometry
    return {
        "scans": log.n_scans,
        "beams": log.n_beams,
        "trajectory": log.default_trajectory,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "resolution": geometry.resolution,
        "findings": [finding.public() for finding in found],
        "limits": asdict(FleetLimits(job.timeout_s, job.cpu_s, job.memory_bytes)),
        "picture": picture,
        "cpu_s": round(time.process_time() - began, 3),
    }
