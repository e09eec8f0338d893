"""Two libraries on one PostgreSQL and one store: what one does the other knows, and each job is done once."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import pytest_asyncio
from sqlalchemy import Connection, insert, select, text

from mapper.core.errors import ConfigError, MapperError
from mapper.editing import EditedMap
from mapper.editing.files import map_files
from mapper.grid import GridGeometry
from mapper.simulation import sample_log
from server.jobs import leases as leasing
from server.jobs.leases import Lease, LeaseLostError, Leases, Once
from server.jobs.record import JobRecord
from server.library.library import Library
from server.library.loading import LibraryLimits
from server.library.packs.map_files import archived
from server.library.packs.reference_map import ReferenceMap, read_reference_map
from server.library.processing.fleet.fleet_job import FleetJob
from server.library.processing.job_rows import JobRowsOfLogs
from server.library.processing.localization import (
    LocalizationKind,
    LocalizationRequest,
    LocalizationResult,
    LocalizeJob,
    LocalizeOutcome,
)
from server.library.processing.slam import SlamJob
from server.library.store.database import Database
from server.library.store.lease_rows import LeaseRows
from server.library.store.tables import jobs, leases, logs
from server.settings import Settings
from server.storage import StorageError
from server.work.fair_lock import FairLock
from tests.server.library.kept import settled
from tests.server.library.postgresql import Cluster
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.small_logs import carmen
from tests.server.service import eventually


async def chunks(data: bytes) -> AsyncIterator[bytes]:
    yield data


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(leasing, "WAIT_S", 0.05)
    monkeypatch.setattr("server.library.logs.sample.simulation", SimpleNamespace(sample_log=lambda: sample_log(5)))


class Two:
    """Two libraries, each with a data folder and a reading process of its own."""

    def __init__(self, first: Library, second: Library, folder: Path) -> None:
        self.first, self.second, self.folder = first, second, folder

    def now(self, work: Any) -> Any:
        return self.first._database.now(work)


@pytest_asyncio.fixture
async def two(postgresql: Cluster, tmp_path: Path) -> AsyncIterator[Two]:
    url = postgresql.new_database()
    made = []
    for name in ("a", "b"):
        settings = Settings(data_dir=tmp_path / name, blobs=str(tmp_path / "bucket"), database=url)  # type: ignore[arg-type]
        made.append(Library(settings, LibraryLimits(lease_s=5.0)))
        await made[-1].start()
    yield Two(made[0], made[1], tmp_path)
    for library in made:
        await library.close()


def known(library: Library, owner: str, log_id: str) -> str:
    """The state of a log as a library knows it, "" for none."""
    try:
        return library.get(owner, log_id).state
    except MapperError:
        return ""


async def test_what_one_service_reads_the_other_opens_without_reading_it(two: Two) -> None:
    record = await two.first.put("ann", "a.log", chunks(carmen(12)))
    assert (await settled(two.first, "ann", record.id)).state == "ready"
    await eventually(lambda: known(two.second, "ann", record.id) == "ready")
    assert known(two.second, "bob", record.id) == ""
    ours, theirs = [await one.load("ann", record.id) for one in (two.first, two.second)]
    assert (ours.ranges == theirs.ranges).all()
    assert two.second._readers.small.worker_pid * two.first._readers.small.worker_pid == 0, (
        "one of them has read it, and only one"
    )
    assert await two.second.map_picture("ann", record.id) == await two.first.map_picture("ann", record.id)
    # Uploaded again there it is the same log, and its pack is not made again.
    assert (await two.second.put("ann", "again.log", chunks(carmen(12)))).id == record.id
    link = await two.first.links.make("ann", record, '{"index": 3}')
    await two.second.tags.put("ann", record, ["yard"])
    await eventually(lambda: bool(two.second.links.of("ann", record.id)) and bool(two.first.tags.of("ann", record.id)))
    assert two.second.links.get(link.token).view == '{"index": 3}'
    await two.second.delete("ann", record.id)
    await eventually(lambda: known(two.first, "ann", record.id) == "")
    left = [path.name for path in two.folder.rglob("*") if path.is_file() and record.id in path.name]
    assert left == []
    assert list((two.folder / "bucket" / "blobs").iterdir()) == []


async def test_a_log_whose_service_vanishes_is_read_by_the_other(two: Two) -> None:
    turn = two.first._readers.small.turn("nobody")
    async with two.second._readers.small.turn("nobody"):  # so that it is queued with the first
        async with turn:
            record = await two.first.put("ann", "a.log", chunks(carmen(9)))
            await eventually(lambda: known(two.second, "ann", record.id) == "queued")
            # The first is gone in the middle of the reading: what it leaves is a lease that nobody renews.
            two.first._jobs._jobs[record.id].cancel()
            held = "INSERT INTO leases SELECT 'read ' || id, 'gone', extract(epoch from now()) + 0.3, 0.5 FROM logs"
            two.now(lambda c: c.execute(text(held)))
            two.now(lambda c: c.execute(text("UPDATE logs SET state = 'reading', attempts = 1")))
        await eventually(lambda: two.second._jobs.progress(record) == 0.5)
    assert (await settled(two.second, "ann", record.id)).state == "ready"
    stored = two.now(lambda c: [(row.state, row.attempts) for row in c.execute(select(logs))])
    assert stored == [("ready", 0)]
    await eventually(lambda: two.now(lambda c: c.execute(select(leases)).all()) == [])


async def test_the_jobs_of_a_service_that_vanishes_are_taken_over(two: Two, monkeypatch: pytest.MonkeyPatch) -> None:
    done = []

    def quickly(job: Any) -> Any:
        done.append(type(job).__name__)
        if isinstance(job, FleetJob):
            return stand_ins.FACTS
        return stand_ins.quick(job) if isinstance(job, SlamJob) else stand_ins.quick_merge(job)

    monkeypatch.setattr("server.library.processing.slam.SlamJob.compute", quickly)
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", quickly)
    monkeypatch.setattr("server.library.processing.fleet.fleet_job.FleetJob.compute", quickly)
    for library in (two.first, two.second):
        for queue in (library.slam, library.merges, library.fleet):
            monkeypatch.setattr(queue, "_make_worker", stand_ins.ThreadWorker)
    ids = []
    for name, start in (("a.log", 0), ("b.log", stand_ins.SECOND_START)):
        record = await two.first.put("ann", name, chunks(carmen(6, start)))
        assert (await settled(two.first, "ann", record.id)).state == "ready"
        ids.append(record.id)
    await eventually(lambda: known(two.second, "ann", ids[1]) == "ready")

    # What a service that was killed in the middle leaves: rows of jobs that run, and leases that nobody renews.
    requests = {"slam": "{}", "merge": json.dumps({"other": ids[1]}), "fleet": "{}"}

    def leave(connection: Connection) -> None:
        for name, request in requests.items():
            connection.execute(
                text("INSERT INTO leases SELECT :name, 'gone', extract(epoch from now()) + 0.3, 0.5"),
                {"name": f"{name} {ids[0]} ann"},
            )
            running = {"state": "running", "created_s": 1.0, "attempts": 1, "request": request}
            connection.execute(insert(jobs).values(kind=name, log_id=ids[0], owner="ann", **running))

    two.now(leave)
    for queue in (two.second.slam, two.second.merges, two.second.fleet):
        await queue.follow(None)
    states = (two.second.slam.state, two.second.merges.state)
    await eventually(lambda: all(state("ann", ids[0]).state == "done" for state in states))
    mapped = [two.second.get("ann", ids[0])]
    await eventually(lambda: two.second.fleet.state(mapped).counts["done"] == 1)
    assert sorted(done) == ["FleetJob", "MergeJob", "SlamJob"], "each once"
    await eventually(lambda: two.first.slam.state("ann", ids[0]).state == "done")
    stored = two.now(
        lambda c: sorted(tuple(row) for row in c.execute(select(jobs.c.kind, jobs.c.state, jobs.c.attempts)))
    )
    assert stored == [("fleet", "done", 0), ("merge", "done", 0), ("slam", "done", 0)]


async def test_the_map_to_localize_in_is_had_by_the_service_that_takes_the_job_over(
    two: Two, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[ReferenceMap] = []

    def quickly(job: LocalizeJob) -> LocalizeOutcome:
        given.append(read_reference_map(Path(job.reference_map)))
        raise ConfigError("test.enough", "This is enough.")

    monkeypatch.setattr("server.library.processing.localization.LocalizeJob.compute", quickly)
    for library in (two.first, two.second):
        monkeypatch.setattr(library.localization, "_make_worker", stand_ins.ThreadWorker)
    record = await two.first.put("ann", "a.log", chunks(carmen(9)))
    assert (await settled(two.first, "ann", record.id)).state == "ready"
    await eventually(lambda: known(two.second, "ann", record.id) == "ready")
    chosen = await two.first.maps.of_log("ann", record.id, record.id, None, None)

    # What a service that was killed in the middle leaves: the row of a job that runs, and a lease that nobody renews.
    job: JobRecord[LocalizationRequest, LocalizationResult] = JobRecord(
        log_id=record.id, owner="ann", request=LocalizationRequest(), state="running", created_s=1.0, attempts=1
    )  # fmt: skip
    held = "INSERT INTO leases SELECT :name, 'gone', extract(epoch from now()) + 0.3, 0.5"

    def leave(connection: Connection) -> None:
        connection.execute(text(held), {"name": f"localization {record.id} ann"})
        JobRowsOfLogs(two.second._database, lambda *_: record).writing(LocalizationKind.jobs, job)(connection)

    two.now(leave)
    await two.second.localization.follow(None)
    await eventually(lambda: two.second.localization.state("ann", record.id).state == "failed")
    error = two.second.localization.state("ann", record.id).error
    assert error is not None
    assert error.code == "test.enough", error
    assert (given[0].values == chosen.values).all()

    # The one that was chosen last is valid for all, whoever had another one before.
    plain = EditedMap(GridGeometry(0.1, 2, 3), np.zeros((2, 3), np.int8))
    await two.second.choose_map("ann", record.id, "plain", chunks(archived(map_files(plain, "plain"))))
    assert (await two.first.maps.get("ann", record.id)).values.shape == (2, 3)
    await two.first.delete("ann", record.id)
    await eventually(lambda: two.second.maps.total_bytes == 0)
    assert two.first.maps.total_bytes == 0
    assert [path.name for path in (two.folder / "bucket").rglob(f"*{record.id}*")] == []


async def test_a_job_is_cancelled_where_it_runs(two: Two, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = asyncio.Event()

    async def endless(*_: object, **__: object) -> None:
        begun.set()
        await asyncio.Event().wait()

    for library in (two.first, two.second):
        monkeypatch.setattr(library._readers.small, "read", endless)
    record = await two.first.put("ann", "a.log", chunks(carmen(9)))
    await begun.wait()
    await eventually(lambda: known(two.second, "ann", record.id) == "reading")
    assert (await two.second.cancel("ann", record.id)).state == "failed"
    await eventually(lambda: record.id not in two.first._jobs.busy)
    assert known(two.first, "ann", record.id) == "failed"
    assert two.now(lambda c: c.execute(select(logs.c.error_code)).scalars().all()) == ["log.cancelled"]


async def test_a_start_leaves_alone_what_another_service_is_receiving(two: Two) -> None:
    half = two.first._blobs.incoming()
    await half.write(b"half of an upload")
    stranger = two.first._blobs.incoming()
    await stranger.write(b"bytes whose record is not written yet")
    await stranger.commit()
    await two.first.put("ann", "a.log", chunks(carmen(5)))
    await two.second._catalogue.start(stores_match=True)
    assert stranger.sha256 in await two.first._blobs.names()
    await half.commit()
    assert half.sha256 in await two.first._blobs.names()


# -- leases ------------------------------------------------------------------------------------------------------------


@pytest_asyncio.fixture
async def databases(postgresql: Cluster, tmp_path: Path) -> AsyncIterator[list[Database]]:
    url = postgresql.new_database()
    made = [Database.open(url, tmp_path) for _ in range(4)]
    yield made
    for one in made:
        one.close()


async def test_a_hundred_jobs_of_four_services_are_each_done_once(databases: list[Database]) -> None:
    left, done = set(range(100)), []

    async def work_of(service: Leases, number: int) -> None:
        async def is_due() -> bool:
            return number in left

        async def work(lease: Lease) -> None:
            await asyncio.sleep(0)
            await lease.finish(lambda _: left.discard(number))
            done.append(number)

        lock = FairLock()
        job = Once(f"job {number}", lambda: lock.of("ann"), lambda: number in left, is_due)
        await service.done_once(job, work)

    services = [Leases(LeaseRows(one, 30.0), 30.0) for one in databases]
    await asyncio.gather(*(work_of(service, number) for number in range(100) for service in services))
    assert sorted(done) == list(range(100))


async def test_who_has_lost_a_lease_writes_nothing(databases: list[Database]) -> None:
    first, second = LeaseRows(databases[0], 1000.0), LeaseRows(databases[1], 1000.0)
    written: list[str] = []
    ours = Leases(first, 3000.0)  # it renews its lease too late: a process that was stopped

    def end(connection: Connection) -> None:
        connection.execute(leases.update().values(until_s=0.0))  # long ago

    async with ours.held("job") as lease:
        assert lease is not None
        assert not await second.take("job")
        databases[1].now(end)
        assert await second.take("job")
        with pytest.raises(LeaseLostError):
            await lease.finish(lambda _: written.append("late"))
    assert written == []
    assert await second.fraction("job") == 0.0, "what is given back is one's own only"
    await second.finish("job", lambda _: written.append("in time"))
    assert written == ["in time"]


async def test_work_without_a_lease_is_cancelled(databases: list[Database]) -> None:
    rows = LeaseRows(databases[0], 0.3)

    def take_away(connection: Connection) -> None:
        connection.execute(leases.delete())

    async def work() -> None:
        async with Leases(rows, 0.3).held("job"):
            databases[1].now(take_away)
            await asyncio.Event().wait()

    with pytest.raises(LeaseLostError):
        await work()


async def test_a_database_that_is_away_ends_the_work_when_the_lease_does(
    databases: list[Database], monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = LeaseRows(databases[0], 0.3)

    async def away(*_: object) -> bool:
        raise StorageError("library.unreachable", "It is away.")

    monkeypatch.setattr(rows, "renew", away)
    with pytest.raises(LeaseLostError):
        async with Leases(rows, 0.3).held("job"):
            await asyncio.Event().wait()
