"""The fleet of a library on a Dask cluster of real processes: workers and the scheduler are killed in the middle."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

import pytest

from server.library.library import Library
from server.library.processing.fleet import cluster_tasks
from server.library.processing.fleet.cluster import Cluster, _pieces
from server.settings import Settings
from tests.server.dask_cluster import DaskCluster, dask_cluster, kill
from tests.server.library.conftest import Make
from tests.server.library.processing.fleets import counts, uploads
from tests.server.library.small_logs import in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[DaskCluster]:
    with dask_cluster(tmp_path / "cluster") as made:
        yield made


@pytest.fixture
def settings(settings: Settings, cluster: DaskCluster) -> Settings:
    return settings.model_copy(update={"fleet_executor": cluster.address})


def state(library: Library) -> dict[str, Any]:
    cluster = library.fleet.state([]).cluster
    assert cluster is not None
    return asdict(cluster)


async def test_a_worker_that_is_killed_loses_no_log(library: Library, cluster: DaskCluster) -> None:
    logs = await uploads(library, 20, 21, 22, 23)
    for log in logs:
        library._catalogue.picture(log.id).unlink()
    assert await library.fleet.begin(logs) == 4
    await eventually(lambda: "not reached" in state(library)["error"])
    assert counts(library, logs) == {"queued": 4}
    cluster.begin_scheduler()
    await eventually(lambda: state(library)["error"] == "The Dask cluster has no workers.")
    first = cluster.begin_worker("first")
    await eventually(lambda: bool(cluster.jobs("first")))
    assert library.fleet.state(logs).workers == 1
    kill(first)
    await eventually(lambda: state(library)["workers"] == 0)
    cluster.begin_worker("second")
    cluster.begin_worker("third")
    await eventually(lambda: counts(library, logs) == {"done": 4})
    done = library.fleet.state(logs).logs
    assert sorted(one.facts.scans for one in done if one.facts) == [20, 21, 22, 23]
    for log in logs:
        assert (await library.map_picture("ann", log.id)).startswith(b"\x89PNG"), "the files have come back"
    await eventually(lambda: not cluster.jobs("second") + cluster.jobs("third"))
    assert state(library) == {"workers": 2, "threads": 2, "error": ""}


@pytest.mark.long
async def test_logs_wait_for_a_scheduler_that_is_killed(library: Library, cluster: DaskCluster) -> None:
    cluster.begin_scheduler()
    worker = cluster.begin_worker("first")
    logs = await uploads(library, 20, 21)
    await library.fleet.begin(logs)
    await eventually(lambda: bool(cluster.jobs("first")))
    cluster.kill_scheduler()
    await eventually(lambda: "not reached" in state(library)["error"])
    kill(worker)
    assert not counts(library, logs).get("failed")
    cluster.begin_scheduler()
    cluster.begin_worker("second")
    await eventually(lambda: counts(library, logs) == {"done": 2})


async def test_stopping_ends_the_job_on_the_worker_and_a_restart_goes_on(
    make_library: Make, cluster: DaskCluster
) -> None:
    cluster.begin_scheduler()
    cluster.begin_worker("first")
    before = make_library()
    await before.start()
    logs = await uploads(before, 20, 21)
    await before.fleet.begin(logs)
    await eventually(lambda: bool(cluster.jobs("first")))
    await before.fleet.stop(logs)
    assert counts(before, logs) == {"none": 2}
    await eventually(lambda: not cluster.jobs("first"))
    await before.fleet.begin(logs)
    await eventually(lambda: bool(cluster.jobs("first")))
    await before.close()
    await eventually(lambda: not cluster.jobs("first"))
    after = make_library()
    await after.start()
    await eventually(lambda: counts(after, logs) == {"done": 2})


async def test_a_job_that_is_cancelled_while_its_log_is_opened_leaves_no_open_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "a.log"
    source.write_bytes(bytes(10))
    opened: list[IO[bytes]] = []
    goes_on = threading.Event()
    open_file = Path.open

    def slow(path: Path, mode: str) -> IO[Any]:
        opened.append(open_file(path, mode))
        goes_on.wait()
        return opened[-1]

    monkeypatch.setattr(Path, "open", slow)
    pieces = asyncio.ensure_future(anext(_pieces(source)))
    await eventually(lambda: len(opened) == 1)
    pieces.cancel()
    await asyncio.gather(pieces, return_exceptions=True)
    goes_on.set()
    await eventually(lambda: opened[0].closed)


async def test_a_worker_with_another_version_gets_no_logs(
    library: Library, cluster: DaskCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.fleet.cluster.package_version", lambda: "0.0.1")
    cluster.begin_scheduler()
    cluster.begin_worker("first")
    await eventually(lambda: "1 of 1 workers get no logs" in state(library)["error"])
    assert "here 0.0.1" in state(library)["error"]
    assert state(library)["threads"] == 0


@pytest.mark.parametrize("says", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n" + 4096 * b"x"])
async def test_what_is_no_scheduler_is_told_and_does_not_keep_the_service_from_ending(
    says: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.fleet.cluster.CONNECT_S", 0.5)
    taken: list[socket.socket] = []

    def take() -> None:
        with contextlib.suppress(OSError):  # it was closed
            while True:
                taken.append(listening.accept()[0])
                taken[-1].sendall(says)

    with socket.create_server(("127.0.0.1", 0)) as listening:
        taking = threading.Thread(target=take)
        taking.start()
        cluster = Cluster(f"tcp://127.0.0.1:{listening.getsockname()[1]}")
        assert "not reached" in (await asyncio.to_thread(cluster.await_first_look)).error
        await asyncio.to_thread(cluster.close)
        assert not any(thread.name == "dask cluster" for thread in threading.enumerate())
        listening.shutdown(socket.SHUT_RDWR)
        taking.join()
    for one in taken:
        one.close()


async def test_what_a_log_fails_with_is_told_and_no_fault_of_the_cluster(
    library: Library, cluster: DaskCluster
) -> None:
    cluster.begin_scheduler()
    cluster.begin_worker("first")
    record = await library.put("ann", "bad.log", in_pieces(b"Dear all,\n"))
    await library.fleet.begin([record])
    await eventually(lambda: counts(library, [record]) == {"failed": 1})
    error = library.fleet.state([record]).logs[0].error
    assert error is not None
    assert error.code == "log.unknown_format"
    assert state(library)["error"] == ""


async def test_a_job_that_nobody_renews_ends_and_files_stay_in_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_tasks, "LEASE_S", 0.2)
    worker: Any = SimpleNamespace(local_directory=str(tmp_path))
    await cluster_tasks.begin_job("t", dask_worker=worker)
    folder = tmp_path / "gridbloom-t"
    for name in ("../lease", "/etc/none", "../../out.txt"):
        with pytest.raises(PermissionError):
            await cluster_tasks.write_piece("t", name, b"x", dask_worker=worker)
    await cluster_tasks.write_piece("t", "bag/a.db3", b"one ", dask_worker=worker)
    await cluster_tasks.write_piece("t", "bag/a.db3", b"two", dask_worker=worker)
    assert (folder / "log" / "bag" / "a.db3").read_bytes() == b"one two"
    assert await cluster_tasks.renew_lease("t", dask_worker=worker) == 0.0
    await eventually(lambda: not folder.exists())
    await asyncio.gather(*cluster_tasks._expiring)
