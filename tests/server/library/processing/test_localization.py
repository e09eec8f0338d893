"""Localization jobs: taken up again with their map after the end of the service, and removed with their log."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry
from server.library.library import Library
from server.library.packs.reference_map import ReferenceMap, read_reference_map
from server.library.processing.localization import (
    LocalizationParameters,
    LocalizationRequest,
    LocalizeJob,
    LocalizeOutcome,
)
from server.settings import Settings
from tests.server.library.kept import files, settled
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")

VALUES = np.array([[0, 100, -1], [0, 50, 0]], dtype=np.int8)
begun: list[LocalizeJob] = []


def endless(job: LocalizeJob) -> LocalizeOutcome:
    """Go on until the files of the job are removed."""
    begun.append(job)
    assert (read_reference_map(Path(job.reference_map)).values == VALUES).all()
    deadline = time.monotonic() + stand_ins.PATIENCE_S
    while Path(job.pack).exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return LocalizeOutcome("map", "scan", None, 0, False, 0, 0.0, 0.0)


async def test_a_job_survives_a_restart_with_its_map(
    make_library: Callable[..., Library], settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: stand_ins.ThreadWorker())
    monkeypatch.setattr("server.library.processing.localization.LocalizeJob.compute", endless)
    begun.clear()
    first = make_library()
    await first.start()
    record = await first.put("ann", "run.log", in_pieces(carmen(6)))
    await settled(first, "ann", record.id)
    with pytest.raises(ConfigError):
        await first.maps.get("ann", record.id)
    ReferenceMap("A map", GridGeometry(0.1, 2, 3, (1.0, 2.0, 0.5)), VALUES).write(first.maps.path("ann", record.id))
    wanted = LocalizationParameters({"alpha1": 0.3, "alpha2": 0.2}, (1.0, 2.0, 0.0))
    await first.localization.begin("ann", record.id, LocalizationRequest(parameters=wanted))
    await eventually(lambda: len(begun) == 1)
    await first.close()

    second = make_library()
    await second.start()
    await eventually(lambda: len(begun) == 2)
    one, two = begun
    assert (
        (one.initial_pose, one.parameters) == (two.initial_pose, two.parameters) == ((1.0, 2.0, 0.0), {"alpha1": 0.3})
    )
    assert second.localization.state("ann", record.id).state == "running"
    await second.delete("ann", record.id)
    assert [name for name in files(settings) if name.startswith(("library/maps/", "library/localization/"))] == []
    assert second.maps.total_bytes == 0
