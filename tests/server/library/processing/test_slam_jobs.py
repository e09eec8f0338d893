"""SLAM jobs: queued, watched, cancelled, taken up again, and kept as one more trajectory of their log."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.sensors.planar.options import PlanarCut
from server.jobs.record import Failure
from server.library.library import Library
from server.library.logs.records import LogNotFoundError
from server.library.packs.graph import read_graph
from server.library.packs.log import read_pack
from server.library.processing.merging import MergeRequest
from server.library.processing.slam import PartialPoses, SlamJob, SlamOutcome, SlamRequest, SlamStatus
from server.settings import Settings
from tests.mapper.io.logs import recorded
from tests.server.library.kept import files, settled
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture(autouse=True)
def worker(monkeypatch: pytest.MonkeyPatch) -> stand_ins.ThreadWorker:
    """The worker of the libraries' SLAM, and a SLAM that finds something at once."""
    made = stand_ins.ThreadWorker()
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: made)
    do(monkeypatch, stand_ins.quick)
    return made


def do(monkeypatch: pytest.MonkeyPatch, work: Callable[..., Any]) -> None:
    monkeypatch.setattr("server.library.processing.slam.SlamJob.compute", work)


async def uploaded(library: Library, owner: str = "ann", start: int = 0) -> str:
    record = await library.put(owner, "run.log", in_pieces(carmen(6, start)))
    await settled(library, owner, record.id)
    return record.id


async def ended(library: Library, log_id: str, owner: str = "ann") -> SlamStatus:
    await eventually(lambda: library.slam.state(owner, log_id).state not in ("queued", "running"))
    return library.slam.state(owner, log_id)


async def test_what_it_finds_is_one_more_trajectory(library: Library, settings: Settings) -> None:
    log_id = await uploaded(library)
    seen: list[PartialPoses | None] = []
    state = await library.slam.begin("ann", log_id)
    library.slam.listen("ann", log_id, seen.append)
    assert state.state in ("queued", "running")
    state = await ended(library, log_id)
    assert (state.state, state.error) == ("done", None)
    assert state.result is not None
    assert asdict(state.result) == {
        "trajectory": "SLAM",
        "odometry": "scan",
        "loops": 1,
        "nodes": 6,
        "cpu_s": 0.25,
        "drift_m": (0.3, None),
        "contradicted": (0.12, None),
        "sharpness": (0.25, 0.75),
        "notes": ("A note.",),
    }
    assert seen[-1] is None
    assert [(one.fraction, len(one.poses)) for one in seen if one is not None] == [(0.5, 3)]
    log = await library.load("ann", log_id)
    assert log.trajectory("SLAM").poses[:, 1].tolist() == [stand_ins.Y] * 6
    assert "from the poses of scan, with 1 loop" in log.trajectory("SLAM").description
    graph = await library.trajectories.graph("ann", log_id, "SLAM")
    assert graph is not None
    assert read_graph(graph)[0].n_loops == 1
    assert [name for name in files(settings) if name.startswith("library/slam/")] == [], "nothing of the job is left"


async def test_it_is_cancelled_and_begun_again(
    library: Library, settings: Settings, monkeypatch: pytest.MonkeyPatch, worker: stand_ins.ThreadWorker
) -> None:
    do(monkeypatch, stand_ins.endless)
    log_id = await uploaded(library)
    await library.slam.begin("ann", log_id)
    await eventually(lambda: library.slam.state("ann", log_id).fraction == 0.5)
    state = library.slam.state("ann", log_id)
    assert (state.state, state.stage, state.scans, state.loops) == ("running", "front end", 3, 1)
    assert state.elapsed_s is not None
    assert state.elapsed_s >= 0.0
    assert (await library.slam.cancel("ann", log_id)).state == "cancelled"
    assert worker.ended == 1, "its process was ended"
    assert "SLAM" not in (await library.load("ann", log_id)).trajectories
    assert [name for name in files(settings) if name.startswith("library/slam/")] == []
    do(monkeypatch, stand_ins.quick)
    await library.slam.begin("ann", log_id)
    assert (await ended(library, log_id)).state == "done"


@pytest.mark.parametrize(
    ("work", "code", "message"),
    [
        (stand_ins.refusing, "slam.no_returns", "No scan of the log has a return."),
        (stand_ins.broken, "slam.failed", "SLAM failed on this log."),
    ],
)
async def test_a_log_that_it_cannot_use_is_said(
    library: Library, monkeypatch: pytest.MonkeyPatch, work: Callable[..., Any], code: str, message: str
) -> None:
    do(monkeypatch, work)
    log_id = await uploaded(library)
    await library.slam.begin("ann", log_id)
    state = await ended(library, log_id)
    assert (state.state, state.error) == ("failed", Failure(code, message))


async def test_a_trajectory_that_the_log_lacks_is_refused(library: Library) -> None:
    log_id = await uploaded(library)
    await library.slam.begin("ann", log_id, SlamRequest(trajectory="gps"))
    state = await ended(library, log_id)
    assert state.error is not None
    assert state.error.code == "log.trajectory"


async def test_one_visitor_has_few_and_others_have_their_turn(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    do(monkeypatch, stand_ins.endless)
    logs = [await uploaded(library, start=k) for k in range(4)]
    for log_id in logs[:3]:
        await library.slam.begin("ann", log_id)
    with pytest.raises(LimitError) as caught:
        await library.slam.begin("ann", logs[3])
    assert caught.value.code == "slam.too_many"
    assert (await library.slam.begin("ann", logs[0])).state in ("queued", "running"), "no second job on a log"
    other = await uploaded(library, "ben")
    await library.slam.begin("ben", other)
    await eventually(lambda: library.slam.state("ann", logs[0]).state == "running")
    assert library.slam.state("ann", logs[2]).ahead == 1
    await library.slam.cancel("ann", logs[0])
    await eventually(
        lambda: "running" in [library.slam.state("ann", logs[1]).state, library.slam.state("ben", other).state]
    )
    await library.slam.cancel("ann", logs[1])
    await eventually(lambda: library.slam.state("ben", other).state == "running")
    assert library.slam.state("ann", logs[2]).state == "queued", "ben has his turn before ann's third job"
    with pytest.raises(LogNotFoundError):
        await library.slam.begin("ben", logs[0])
    assert library.slam.state("ann", logs[3]).state == "none"


async def test_it_survives_a_restart(make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch) -> None:
    do(monkeypatch, stand_ins.endless)
    first = make_library()
    await first.start()
    log_id, done = await uploaded(first, start=9), await uploaded(first)
    await first.slam.begin("ann", log_id)
    await eventually(lambda: first.slam.state("ann", log_id).fraction == 0.5)
    await first.close()
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: stand_ins.ThreadWorker())
    second = make_library()
    await second.start()
    await eventually(lambda: second.slam.state("ann", log_id).fraction == 0.5)
    await second.close()
    third = make_library()
    await third.start()
    state = third.slam.state("ann", log_id)
    assert state.error is not None
    assert (state.state, state.error.code) == ("failed", "slam.interrupted")
    do(monkeypatch, stand_ins.quick)
    await third.slam.begin("ann", done)
    await ended(third, done)
    await third.close()
    fourth = make_library()
    await fourth.start()
    result = fourth.slam.state("ann", done).result
    assert result is not None
    assert result.loops == 1
    assert "SLAM" in (await fourth.load("ann", done)).trajectories


async def test_scans_of_clouds_are_those_of_the_session_s_cut(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also of a job that a restart of the service interrupted: its row says how its scans are cut."""
    beams: list[int] = []

    def counted(job: SlamJob) -> SlamOutcome:
        beams.append(read_pack(Path(job.pack)).n_beams)
        return stand_ins.endless(job) if len(beams) == 1 else stand_ins.quick(job)

    do(monkeypatch, counted)
    points = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5]])
    said = [recorded.cloud((1000 + k) * recorded.SECOND, points) for k in range(6)]
    said += [recorded.odometry((1000 + k) * recorded.SECOND, 0.1 * k, 0.0, 0.0) for k in range(6)]
    library = make_library()
    await library.start()
    record = await library.put("ann", "run.mcap", in_pieces(recorded.mcap_bytes(said)))
    await settled(library, "ann", record.id)
    await library.slam.begin("ann", record.id, SlamRequest(cut={"angle_increment": 0.05}))
    await eventually(lambda: library.slam.state("ann", record.id).fraction == 0.5)
    await library.close()
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: stand_ins.ThreadWorker())
    again = make_library()
    await again.start()
    await ended(again, record.id)
    assert beams == [PlanarCut(angle_increment=0.05).n_beams] * 2
    with pytest.raises(ConfigError, match="angle_increment"):
        await again.slam.begin("ann", record.id, SlamRequest(cut={"angle_increment": 0.0}))


async def test_a_merge_survives_a_restart(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", stand_ins.endless_merge)
    first = make_library()
    await first.start()
    one, other = await uploaded(first), await uploaded(first, start=stand_ins.SECOND_START)
    await first.merges.begin("ann", one, MergeRequest(other))
    await eventually(lambda: first.merges.state("ann", one).stage == "loops")
    await first.close()
    monkeypatch.setattr("server.library.library.worker_at", lambda *_: stand_ins.ThreadWorker())
    monkeypatch.setattr("server.library.processing.merging.MergeJob.compute", stand_ins.quick_merge)
    second = make_library()
    await second.start()
    await eventually(lambda: second.merges.state("ann", one).state == "done")
    await second.close()
    third = make_library()
    await third.start()
    state = third.merges.state("ann", one)
    assert state.result is not None
    assert (state.other, state.result.loops, state.result.topic) == (other, 7, None)
    assert third.get("ann", state.result.log).name == "run and run, merged.mcap"
    assert "merged" in (await third.load("ann", other)).trajectories
    await third.delete("ann", one)
    assert third.merges.state("ann", other).state == "none"
    await third.close()


async def test_it_ends_with_its_log(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    do(monkeypatch, stand_ins.endless)
    log_id = await uploaded(library)
    await library.slam.begin("ann", log_id)
    await eventually(lambda: library.slam.state("ann", log_id).fraction == 0.5)
    await library.delete("ann", log_id)
    assert "slam" not in [task.get_name() for task in asyncio.all_tasks()]
