"""Trajectories that visitors add to logs: stored with the log, shown to their owner, deleted with the log."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError, ReadError
from server.library.annotations.added import TrajectoryNotFoundError
from server.library.annotations.trajectories import NewTrajectory
from server.library.library import Library
from server.library.logs.records import LogNotFoundError
from server.settings import Settings
from tests.server.library.kept import files, settled
from tests.server.library.small_logs import carmen, in_pieces, tum

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def added(library: Library, owner: str, log_id: str, name: str, text: bytes) -> Any:
    found, _ = await library.add_trajectory(owner, log_id, name, in_pieces(text))
    return found


async def uploaded(library: Library, owner: str, scans: int = 6) -> str:
    record = await library.put(owner, "run.log", in_pieces(carmen(scans)))
    await settled(library, owner, record.id)
    return record.id


async def test_an_added_trajectory_is_shown_to_its_owner(library: Library) -> None:
    log_id = await uploaded(library, "ann")
    plain = await library.load("ann", log_id)
    await added(library, "ann", log_id, "from LaMa", tum(6, y=2.0))
    log = await library.load("ann", log_id)
    assert [*log.trajectories] == [*plain.trajectories, "from LaMa"]
    np.testing.assert_allclose(log.trajectory("from LaMa").poses, [[i, 2.0, 0.0] for i in range(6)])
    assert log.ranges is plain.ranges, "the readings are shared"
    (shown,) = [one for one in library.get("ann", log_id).public().trajectories if one.source == "tum"]
    assert (shown.name, shown.length_m, shown.has_graph) == ("from LaMa", 5.0, False)
    assert await library.trajectories.text("ann", log_id, "from LaMa") == tum(6, y=2.0)
    await added(library, "ann", log_id, "from LaMa", tum(6, y=3.0))
    assert (await library.load("ann", log_id)).trajectory("from LaMa").poses[0].tolist() == [0.0, 3.0, 0.0]
    assert len(library.trajectories.of("ann", log_id)) == 1
    await library.trajectories.delete("ann", log_id, "from LaMa")
    assert await library.load("ann", log_id) is plain
    with pytest.raises(TrajectoryNotFoundError):
        await library.trajectories.text("ann", log_id, "from LaMa")


async def test_of_a_log_that_all_see_only_its_owner_sees_it(library: Library, settings: Settings) -> None:
    assert settings.logs_dir is not None
    (settings.logs_dir / "lecture.log").write_bytes(carmen(6))
    log_id = next(one.id for one in await library.list("ann") if one.name == "lecture.log")
    await added(library, "ann", log_id, "mine", tum(6))
    assert "mine" in (await library.load("ann", log_id)).trajectories
    assert "mine" not in (await library.load("ben", log_id)).trajectories
    assert library.trajectories.of("ben", log_id) == []
    with pytest.raises(TrajectoryNotFoundError):
        await library.trajectories.delete("ben", log_id, "mine")
    with pytest.raises(LogNotFoundError):
        await library.add_trajectory("ben", "nothing", "mine", in_pieces(tum(6)))


async def test_an_added_trajectory_is_deleted_with_its_log(library: Library, settings: Settings) -> None:
    before = files(settings)
    log_id = await uploaded(library, "ann")
    await added(library, "ann", log_id, "one", tum(6))
    record, log = library.get("ann", log_id), await library.load("ann", log_id)
    await library.trajectories.put("ann", record, log, NewTrajectory("two", tum(6), "slam", "SLAM", b"a graph"))
    assert await library.trajectories.graph("ann", log_id, "two") == b"a graph"
    assert sum(name.startswith("library/trajectories/") for name in files(settings)) == 3
    await library.delete("ann", log_id)
    assert files(settings) == before
    assert library.trajectories.total_bytes == 0


async def test_it_is_there_after_a_restart(make_library: Callable[..., Library], settings: Settings) -> None:
    first = make_library()
    await first.start()
    log_id = await uploaded(first, "ann")
    await added(first, "ann", log_id, "kept", tum(6, y=1.0))
    await first.close()
    stray = settings.data_dir / "library" / "trajectories" / "0123.tum"
    stray.write_bytes(b"of a service that ended while it wrote")
    second = make_library()
    await second.start()
    assert (await second.load("ann", log_id)).trajectory("kept").poses[2].tolist() == [2.0, 1.0, 0.0]
    assert not stray.exists()


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("ok", b"", "trajectory.empty"),
        ("ok", b"1 2 3\n", "trajectory.columns"),
        ("ok", b"0 nan 0 0 0 0 0 1\n", "trajectory.pose"),
        ("ok", b"0 0 0 0 0 0 0 0\n", "trajectory.rotation"),
        ("ok", b"500 0 0 0 0 0 0 1\n", "trajectory.time"),
        ("ok", b"\x1f\x8b\x08\x00broken", "trajectory.columns"),
        ("scan", tum(6), "trajectory.name"),
        (" padded ", tum(6), "trajectory.name"),
        ("x" * 81, tum(6), "trajectory.name"),
        ("a\nb", tum(6), "trajectory.name"),
    ],
)
async def test_an_invalid_trajectory_is_refused(
    library: Library, settings: Settings, name: str, text: bytes, code: str
) -> None:
    log_id = await uploaded(library, "ann")
    before = files(settings)
    with pytest.raises((ConfigError, ReadError)) as caught:
        await added(library, "ann", log_id, name, text)
    assert caught.value.code == code
    assert files(settings) == before
    await library.delete("ann", log_id)


async def test_there_can_be_too_many_and_too_large(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.annotations.trajectories.MAX_OF_LOG", 2)
    monkeypatch.setattr("server.library.annotations.trajectories.MAX_BYTES", 1000)
    log_id = await uploaded(library, "ann")
    results = await asyncio.gather(
        *(added(library, "ann", log_id, name, tum(6)) for name in "abc"), return_exceptions=True
    )
    (refused,) = [one for one in results if isinstance(one, LimitError)]
    assert refused.code == "trajectory.too_many"
    await added(library, "ann", log_id, library.trajectories.of("ann", log_id)[0].name, tum(6))  # in its place
    with pytest.raises(LimitError, match="0 MiB") as caught:
        await added(library, "ann", log_id, "a", tum(100))
    assert caught.value.code == "trajectory.too_large"
