"""SLAM as a kind of jobs on logs: what it makes is one more trajectory of the log, with its pose graph."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from server.library.annotations.trajectories import NewTrajectory
from server.library.processing.pose_job_kind import JobLimits
from server.library.processing.pose_job_record import PoseJobRecord
from server.library.processing.slam_job import GRAPH, NAME, TUM, PartialPoses, SlamJob, SlamOutcome, read_progress
from server.library.store.tables import slam_jobs


class SlamKind:
    """SLAM of logs: a :class:`server.library.processing.pose_jobs.JobKind`."""

    name = "slam"
    title = "SLAM"
    table = slam_jobs

    def checked(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Return the parameters that differ from the first values."""
        return changed_parameters(parameters)

    async def job(self, record: PoseJobRecord, pack: Path, out: Path, limits: JobLimits) -> SlamJob:
        """Return the job on the log in ``pack``."""
        return SlamJob(
            str(pack), str(out), record.trajectory, record.parameters, record.mapping or {}, limits.timeout_s,
            limits.cpu_s, limits.memory_bytes,
        )  # fmt: skip

    def read_progress(self, out: Path) -> PartialPoses | None:
        """Return what a running job has reported last."""
        return read_progress(out)

    def shown(self, newest: PartialPoses | None) -> dict[str, Any]:
        """Return the stage, and how many scans have poses, and how many loops have closed."""
        if newest is None:
            return {"stage": None, "scans": 0, "loops": 0}
        return {"stage": newest.stage, "scans": len(newest.poses), "loops": newest.n_loops}

    async def finished(
        self,
        record: PoseJobRecord,  # noqa: ARG002 - what another kind needs
        outcome: SlamOutcome,
        out: Path,
        own_names: Sequence[str],
    ) -> tuple[NewTrajectory, dict[str, Any]]:
        """Return the corrected poses with their graph, and what is shown of them."""
        text, graph = await asyncio.to_thread(
            lambda: (out.with_name(out.name + TUM).read_bytes(), out.with_name(out.name + GRAPH).read_bytes())
        )
        name = NAME if NAME not in own_names else f"{NAME} (healed)"
        start = "the scans alone" if outcome.odometry is None else f"the poses of {outcome.odometry}"
        loops = "1 loop" if outcome.loops == 1 else f"{outcome.loops} loops"
        said = f"poses corrected by SLAM, from {start}, with {loops}"
        return NewTrajectory(name, text, "slam", said, graph), {
            "odometry": outcome.odometry,
            "loops": outcome.loops,
            "nodes": outcome.nodes,
            "cpu_s": round(outcome.cpu_s, 2),
            **{
                name: [_rounded(getattr(one, name)) for one in (outcome.before, outcome.after)]
                for name in ("drift_m", "contradicted", "sharpness")
            },
            "notes": list(outcome.notes),
        }


def _rounded(value: float | None) -> float | None:
    return round(value, 4) if value is not None and math.isfinite(value) else None


def changed_parameters(values: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters of SLAM that differ from the first values (worker thread: it imports SLAM).

    Raises :class:`mapper.core.errors.ConfigError` for a name or a value that is refused.
    """
    from mapper.slam.config import SlamConfig  # noqa: PLC0415 - few visitors begin SLAM

    first = SlamConfig().as_dict()
    return {name: value for name, value in SlamConfig().with_values(values).as_dict().items() if value != first[name]}


def parameter_table() -> list[dict[str, Any]]:
    """Return the table of SLAM's parameters (worker thread: it imports SLAM)."""
    from mapper.slam.config import SLAM_PARAMETERS  # noqa: PLC0415 - few visitors begin SLAM

    return [asdict(row) for row in SLAM_PARAMETERS]
