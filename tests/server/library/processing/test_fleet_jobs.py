"""The logs of a library as a fleet: each mapped once, the results kept, told as they come, and gone with their logs."""

from __future__ import annotations

import asyncio
import math
import os
import threading
from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from mapper.core.errors import LimitError, ReadError
from server.jobs.record import Failure
from server.library.library import Library
from server.library.processing.fleet.fleet_job import FleetJob, MapFacts
from server.library.processing.fleet.fleet_jobs import FleetRequest
from server.settings import Settings
from tests.server.library.conftest import Make
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.processing.fleets import counts, uploads
from tests.server.service import PATIENCE_S, eventually

COMPUTE = FleetJob.compute

pytestmark = pytest.mark.asyncio(loop_scope="module")


class Doing:
    """Stands in for the mapping: counts the logs, waits where it is told to, and refuses those of four scans."""

    def __init__(self) -> None:
        self.done: Counter[str] = Counter()
        self.at_once = self.most = 0
        self.may_go_on = threading.Event()
        self.may_go_on.set()
        self._lock = threading.Lock()

    def __call__(self, job: FleetJob) -> MapFacts:
        text = Path(job.source).read_bytes()
        with self._lock:
            self.at_once += 1
            self.most = max(self.most, self.at_once)
        assert self.may_go_on.wait(PATIENCE_S)
        with self._lock:
            self.at_once -= 1
            self.done[job.picture] += 1
        if text.count(b"\n") == 4:
            raise ReadError("log.no_scans", "The log holds no scans.")
        return stand_ins.FACTS


@pytest.fixture(autouse=True)
def doing(monkeypatch: pytest.MonkeyPatch) -> Doing:
    made = Doing()
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: stand_ins.ThreadWorker())
    monkeypatch.setattr(FleetJob, "compute", property(lambda job: partial(made, job)))
    return made


@pytest.fixture
def settings(settings: Settings) -> Settings:
    return settings.model_copy(update={"fleet_workers": 2})


async def test_each_log_is_mapped_once_and_what_changes_is_told(library: Library, doing: Doing) -> None:
    logs = await uploads(library, 3, 4, 5, 6, 7)
    first = library.fleet.state(logs)
    assert (first.whole, first.workers, counts(library, logs)) == (True, 2, {"none": 5})
    doing.may_go_on.clear()
    assert await library.fleet.begin(logs) == 5
    assert await library.fleet.begin(logs) == 0, "they are under way"
    await eventually(lambda: doing.at_once == 2)
    assert counts(library, logs) == {"queued": 3, "running": 2}
    doing.may_go_on.set()
    await eventually(lambda: counts(library, logs) == {"done": 4, "failed": 1})
    assert (set(doing.done.values()), len(doing.done), doing.most) == ({1}, 5, 2)
    told = library.fleet.state(logs, first.revision or 1)
    assert (told.whole, len(told.logs)) == (False, 5)
    assert library.fleet.state(logs, told.revision).logs == []
    failed = next(one for one in told.logs if one.state == "failed")
    assert (failed.name, failed.error) == ("4.log", Failure("log.no_scans", "The log holds no scans."))
    facts = next(one for one in told.logs if one.name == "3.log").facts
    assert facts is not None
    assert facts.scans == 1
    # What failed is mapped again only when that is asked for.
    assert await library.fleet.begin(logs) == 0
    assert await library.fleet.begin(logs, again=True) == 1
    await eventually(lambda: counts(library, logs) == {"done": 4, "failed": 1})
    assert doing.done.total() == 6
    # With other options all are mapped anew, and with the same ones none.
    other = FleetRequest(topic="FLASER", mapping={"mount_yaw": math.pi / 2, "time_offset": 0.5})
    assert [await library.fleet.begin(logs, request=one) for one in (FleetRequest(), other)] == [0, 5]
    await eventually(lambda: counts(library, logs) == {"done": 4, "failed": 1})
    said = {one.options for one in library.fleet.state(logs).logs}
    assert said == {"sensor FLASER, mount 0 m, 0 m, 90°, time offset 0.5 s"}
    assert await library.fleet.begin(logs, request=other) == await library.fleet.begin(logs) == 0
    # A log that is deleted takes its result along, and who looked before is told all.
    await library.delete("ann", logs[0].id)
    assert library.fleet.state(logs[1:], told.revision).whole
    assert counts(library, logs[1:]) == {"done": 3, "failed": 1}


async def test_the_logs_that_wait_are_mapped_after_a_restart(make_library: Make, doing: Doing) -> None:
    before = make_library()
    await before.start()
    logs = await uploads(before, 3, 5, 6, 7)
    await before.fleet.begin(logs[:2])
    await eventually(lambda: counts(before, logs) == {"done": 2, "none": 2})
    doing.may_go_on.clear()
    await before.fleet.begin(logs)
    await eventually(lambda: doing.at_once == 2)
    ending = asyncio.create_task(before.close())
    await asyncio.sleep(0)
    doing.may_go_on.set()
    await ending
    after = make_library()
    await after.start()
    await eventually(lambda: counts(after, logs) == {"done": 4})
    assert doing.done[str(after._catalogue.picture(logs[0].id))] == 1, "it was done before"


async def test_it_can_be_stopped_and_has_a_limit(
    library: Library, doing: Doing, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = await uploads(library, 3, 5, 6)
    doing.may_go_on.clear()
    await library.fleet.begin(logs)
    await eventually(lambda: doing.at_once == 2)
    await library.fleet.stop(logs)
    assert counts(library, logs) == {"none": 3}
    doing.may_go_on.set()
    monkeypatch.setattr("server.library.processing.fleet.fleet_jobs.MOST", 2)
    with pytest.raises(LimitError) as caught:
        await library.fleet.begin(logs)
    assert caught.value.code == "fleet.too_many"


async def test_the_facts_and_the_picture_are_those_of_the_log(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.jobs.process.lower_priority", lambda: None)
    monkeypatch.setattr(FleetJob, "compute", COMPUTE)
    (log,) = await uploads(library, 30)
    assert library.fleet.state([log]).logs[0].has_picture, "drawn when the log was read"
    library._catalogue.picture(log.id).unlink()
    assert not library.fleet.state([log]).logs[0].has_picture
    await library.fleet.begin([log])
    await eventually(lambda: counts(library, [log]) == {"done": 1})
    facts = library.fleet.state([log]).logs[0].facts
    assert library.fleet.state([log]).logs[0].has_picture
    assert facts is not None
    assert (facts.scans, facts.beams, facts.picture, facts.runs) == (30, 3, True, 1)
    assert facts.cols * facts.resolution > 29.0, "the robot drives 29 m"
    assert facts.drift_m is None, "too little was seen twice"
    assert (await library.map_picture("ann", log.id)).startswith(b"\x89PNG")


async def test_the_list_and_the_state_look_for_pictures_off_the_event_loop(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    (log,) = await uploads(library, 3)
    looked: list[tuple[int, str]] = []
    stat = os.stat

    def noted(path: Any, **options: Any) -> os.stat_result:
        looked.append((threading.get_ident(), str(path)))
        return stat(path, **options)

    monkeypatch.setattr(os, "stat", noted)
    listed = await library.list(log.owner)
    pictured = await asyncio.to_thread(library.pictured)
    state = library.fleet.state([log], 0, pictured)
    assert [record.has_picture for record in listed if record.id == log.id] == [log.id in pictured]
    assert state.logs[0].has_picture == (log.id in pictured)
    here = threading.get_ident()
    assert [path for thread, path in looked if thread == here and path.endswith(".png")] == []
