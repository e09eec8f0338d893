"""Localization as a kind of jobs on logs: what it makes is one more trajectory of the log, in the frame of a map."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mapper.core.errors import ConfigError
from server.library.annotations.trajectories import NewTrajectory
from server.library.processing.given_maps import GivenMaps
from server.library.processing.localize_job import (
    COURSE,
    TUM,
    LocalizeJob,
    LocalizeOutcome,
    LocalizeProgress,
    read_progress,
)
from server.library.processing.pose_job_kind import JobLimits
from server.library.processing.pose_job_record import PoseJobRecord
from server.library.store.tables import localization_jobs

NAME = "localized"  #: of the trajectory


class LocalizationKind:
    """Localization of logs in the maps that their visitors chose: a :class:`JobKind`."""

    name = "localization"
    title = "Localization"
    table = localization_jobs

    def __init__(self, maps: GivenMaps) -> None:
        self._maps = maps

    def checked(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Return ``values`` that differ from the first ones, and ``initial_pose`` (3,) or None for anywhere."""
        pose = parameters.get("initial_pose")
        return {
            "values": changed_values(parameters.get("values", {})),
            "initial_pose": None if pose is None else [*pose],
        }

    async def job(self, record: PoseJobRecord, pack: Path, out: Path, limits: JobLimits) -> LocalizeJob:
        """Return the job on the log in ``pack``. Raises :class:`ConfigError` where no map was chosen."""
        given = pack.with_name("map.npz")
        try:
            await asyncio.to_thread(shutil.copyfile, await self._maps.newest(record.owner, record.log_id), given)
        except FileNotFoundError:
            raise ConfigError("localization.no_map", "Choose a map to localize the log in first.") from None
        pose = record.parameters["initial_pose"]
        return LocalizeJob(
            str(pack), str(given), str(out), record.trajectory, None if pose is None else (pose[0], pose[1], pose[2]),
            record.parameters["values"], record.mapping or {}, limits.timeout_s, limits.cpu_s, limits.memory_bytes,
        )  # fmt: skip

    def read_progress(self, out: Path) -> LocalizeProgress | None:
        """Return what a running job has reported last."""
        return read_progress(out)

    def shown(self, newest: LocalizeProgress | None) -> dict[str, Any]:
        """Return how many scans have poses, and whether the filter has converged."""
        if newest is None:
            return {"scans": 0, "is_converged": False, "n_particles": 0}
        return {
            "scans": len(newest.poses), "is_converged": newest.is_converged, "n_particles": newest.n_particles
        }  # fmt: skip

    async def finished(
        self, record: PoseJobRecord, outcome: LocalizeOutcome, out: Path, own_names: Sequence[str]
    ) -> tuple[NewTrajectory, dict[str, Any]]:
        """Return the poses in the map with their course, and what is shown of them."""
        text, course = await asyncio.to_thread(
            lambda: (out.with_name(out.name + TUM).read_bytes(), out.with_name(out.name + COURSE).read_bytes())
        )
        name = NAME if NAME not in own_names else f"{NAME} in a map"
        first = outcome.first_converged
        when = "which never converged" if first is None else f"converged from scan {first + 1} on"
        start = "anywhere" if record.parameters["initial_pose"] is None else "a given pose"
        said = f"localized in {outcome.map_title} by the poses of {outcome.odometry}, from {start}, {when}"
        shown = asdict(outcome) | {"cpu_s": round(outcome.cpu_s, 2), "median_fit": round(outcome.median_fit, 4)}
        return NewTrajectory(name, text, "localized", said, course=course), shown


def changed_values(values: dict[str, Any]) -> dict[str, Any]:
    """Return the localization parameters that differ from the first values (worker thread: it imports the filter).

    Raises :class:`mapper.core.errors.ConfigError` for a name or a value that is refused.
    """
    from mapper.localization import LocalizationConfig  # noqa: PLC0415 - few visitors localize a log

    first = LocalizationConfig().as_dict()
    return {
        name: value
        for name, value in LocalizationConfig().with_values(values).as_dict().items()
        if value != first[name]
    }


def parameter_table() -> list[dict[str, Any]]:
    """Return the table of localization's parameters (worker thread: it imports the filter)."""
    from mapper.localization import PARAMETERS  # noqa: PLC0415 - few visitors localize a log

    return [asdict(row) for row in PARAMETERS]
