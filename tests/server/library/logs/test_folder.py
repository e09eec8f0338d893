"""The shared folder of the operator, and the sample: read without a request, and open to all visitors."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import os
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from mapper.volume import OccupancyVolume, Octree, VolumeConfig, octree_file, write_octree
from mapper.volume.scans.scan_sequence import ScanSequence
from server.library.library import Library
from server.library.logs.folder import MAX_FILES
from server.library.logs.records import LogNotFoundError, LogReadOnlyError, Record
from server.library.logs.sample import SAMPLE_ID
from server.settings import Settings
from tests.mapper.io.logs.containers.test_split import split
from tests.server.library.kept import files, settled
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture
def folder(settings: Settings) -> Path:
    assert settings.logs_dir is not None
    return settings.logs_dir


async def in_folder(library: Library) -> dict[str, Record]:
    """The folder's logs by name."""
    return {record.name: record for record in await library.list("ann") if record.source == "folder"}


async def surveyed(library: Library) -> dict[str, Record]:
    """The folder's logs once all is known of them."""
    for record in (await in_folder(library)).values():
        await settled(library, "ann", record.id)
    return await in_folder(library)


async def test_the_folder_lists_its_logs_and_nothing_else(library: Library, settings: Settings, folder: Path) -> None:
    (folder / "b.log").write_bytes(carmen(6))
    (folder / "A.log.gz").write_bytes(gzip.compress(carmen(9)))
    (folder / "no name for a log").write_bytes(b"# found in a drawer\n" + carmen(2))
    (folder / ".hidden").write_bytes(carmen(1))
    (folder / "sub").mkdir()
    outside = settings.data_dir.parent / "secret.log"
    outside.write_bytes(carmen(1))
    (folder / "link.log").symlink_to(outside)
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "twin.log").symlink_to(folder / "b.log")
    os.mkfifo(folder / "pipe")
    (folder / "README.log").write_text("# Logs\n\nThese are logs.\n")
    (folder / "b.tum").write_text("976052857.1 0.1 0.2 0 0 0 0 1\n" * 50)
    (folder / "map.pgm").write_bytes(b"P5\n2 2\n255\n\0\0\0\0")
    (folder / "map.log.gz").write_bytes(gzip.compress(b"P5\n2 2\n255\n\0\0\0\0"))
    (folder / "broken.log.gz").write_bytes(b"\x1f\x8b\x08" + bytes(range(40)))
    (folder / "empty.log").write_bytes(b"")
    np.savetxt(folder / "matrix.txt", np.eye(4))
    assert list(await in_folder(library)) == ["A.log.gz", "b.log", "no name for a log", "twin.log"]


async def test_a_folder_in_it_that_is_one_log_is_one_log(
    library: Library, settings: Settings, folder: Path, tmp_path: Path
) -> None:
    run, whole = split(tmp_path, "mcap", 3)
    run.rename(folder / "run")
    for name in ("two logs", "leads out", "deep", "many"):
        (folder / name).mkdir()
    for n in range(2):
        (folder / "two logs" / f"{n}.log").write_bytes(carmen(2 + n))
    outside = settings.data_dir.parent / "secret.log"
    outside.write_bytes(carmen(1))
    (folder / "leads out" / "link.log").symlink_to(outside)
    (folder / "deep" / "er").mkdir()
    (folder / "deep" / "a.log").write_bytes(carmen(3))
    for n in range(MAX_FILES):
        (folder / "many" / f"{n}.txt").touch()
    (folder / "many" / "a.log").write_bytes(carmen(3))
    found = await surveyed(library)
    assert {name: (record.state, record.summary and record.summary.scans) for name, record in found.items()} == {
        "run": ("ready", 24)
    }
    expected = await asyncio.to_thread(open_log, whole)
    log = await library.load("bob", found["run"].id)
    assert log.stamps_ns.tolist() == expected.stamps_ns.tolist()
    (folder / "run" / "run_2.mcap").unlink()
    again = await surveyed(library)
    assert again["run"].id != found["run"].id, "it is another log now"
    assert again["run"].summary is not None
    assert again["run"].summary.scans < 24


async def test_clouds_octrees_and_depth_images_of_the_folder_are_listed(library: Library, folder: Path) -> None:
    points = np.random.default_rng(1).uniform(-2.0, 2.0, (60, 3))
    np.savetxt(folder / "yard.xyz", points)
    volume = OccupancyVolume(VolumeConfig(resolution=0.5))
    volume.insert_scan(points, np.zeros(3))
    write_octree(octree_file(Octree.of(volume), ".bt", volume.config), folder / "yard.bt")
    (folder / "room").mkdir()
    (folder / "tum" / "depth").mkdir(parents=True)
    depth = Image.fromarray(np.full((4, 4), 1500, dtype=np.uint16))
    for k in range(60):  # more files than another log has in one folder
        depth.save(folder / "room" / f"frame-{k:06d}.depth.png")
        np.savetxt(folder / "room" / f"frame-{k:06d}.pose.txt", np.diag([1.0, -1.0, -1.0, 1.0]))
    depth.save(folder / "tum" / "depth" / "1.0.png")
    (folder / "tum" / "depth.txt").write_text("1.0 depth/1.0.png\n")
    (folder / "tum" / "groundtruth.txt").write_text("1.0 0 0 0 0 0 0 1\n")
    for one in ("room", "tum"):
        (folder / one / "intrinsics.txt").write_text("4 4 2 2\n")
    found = await surveyed(library)
    assert {name: (one.state, one.summary and one.summary.clouds) for name, one in found.items()} == {
        "room": ("ready", 60),
        "tum": ("ready", 1),
        "yard.bt": ("ready", 1),
        "yard.xyz": ("ready", 1),
    }
    source = await library.volume("bob", found["room"].id)
    assert isinstance(source, ScanSequence)
    assert source.first_up == "y", "the columns of the images point to -y"


async def test_logs_of_the_folder_are_read_without_a_request(
    make_library: Callable[..., Library], settings: Settings, folder: Path
) -> None:
    (folder / "a.log").write_bytes(carmen(6))
    (folder / "b.log").write_bytes(carmen(2) + b"FLASER 3 1.0\n" + carmen(1))
    (folder / "c.log.gz").write_bytes(gzip.compress(carmen(9)))
    library = make_library()
    await library.start()
    at_once = await in_folder(library)
    assert all(one.state in ("queued", "reading") and one.summary is None for one in at_once.values())
    logs = await surveyed(library)
    assert [(name, one.state, one.public().scans) for name, one in logs.items()] == [
        ("a.log", "ready", 6),
        ("b.log", "failed", None),
        ("c.log.gz", "ready", 9),
    ]
    assert logs["b.log"].error is not None
    assert "Line 3" in logs["b.log"].error.message
    assert logs["a.log"].public().duration_s == 5.0
    assert not [name for name in files(settings) if name.startswith("library/packs")], "nobody has opened any"

    # A log that is dropped into the folder is there at the next look.
    (folder / "d.log").write_bytes(carmen(4))
    assert (await in_folder(library))["d.log"].state != "ready"
    assert (await surveyed(library))["d.log"].public().scans == 4
    await library.close()

    # What is known is known after a restart as well, while the files are the same.
    (folder / "a.log").unlink()
    (folder / "b.log").unlink()
    (folder / "d.log").write_bytes(carmen(5))
    second = make_library(own_reader=True)
    await second.start()
    known = await in_folder(second)
    assert list(known) == ["c.log.gz", "d.log"]
    assert known["c.log.gz"] == logs["c.log.gz"]
    assert known["d.log"].state != "ready"
    assert (await surveyed(second))["d.log"].public().scans == 5


async def test_a_log_of_the_folder_opens_for_everybody(library: Library, folder: Path) -> None:
    (folder / "run.log").write_bytes(carmen(9))
    record = (await in_folder(library))["run.log"]
    # Before, while and after it is found out what it holds.
    logs = await asyncio.gather(library.load("ann", record.id), library.load("bob", record.id))
    assert [log.n_scans for log in logs] == [9, 9]
    assert library.get("bob", record.id).state == "ready"
    with pytest.raises(LogReadOnlyError):
        await library.delete("ann", record.id)

    # The id says which bytes: another file by the same name is another log.
    (folder / "run.log").write_bytes(carmen(11))
    changed = (await in_folder(library))["run.log"]
    assert changed.id != record.id
    await surveyed(library)
    assert (await library.load("ann", changed.id)).n_scans == 11
    with pytest.raises(LogNotFoundError):
        library.get("ann", record.id)


async def test_opening_a_log_does_not_wait_for_the_whole_folder(
    make_library: Callable[..., Library], folder: Path
) -> None:
    for i in range(20):
        (folder / f"{i}.log").write_bytes(carmen(3000 + i))
    library = make_library()
    await library.start()
    last = (await in_folder(library))["9.log"]
    assert (await library.load("ann", last.id)).n_scans == 3009
    assert "queued" in [one.state for one in library._folder.records()]


async def test_a_log_of_the_folder_that_fails_has_its_reason(library: Library, folder: Path) -> None:
    (folder / "bad.log").write_bytes(b"PARAM robot_width 1 host 1\n")
    record = (await in_folder(library))["bad.log"]
    with pytest.raises(ReadError) as caught:
        await library.load("ann", record.id)
    assert caught.value.code == "log.no_scans"
    assert str(folder) not in caught.value.message
    assert library.get("ann", record.id).state == "failed"


async def test_a_record_of_an_older_summary_finds_it_out_again(
    make_library: Callable[..., Library], settings: Settings
) -> None:
    first = make_library()
    await first.start()
    record = await first.put("ann", "run.log", in_pieces(carmen(7)))
    await settled(first, "ann", record.id)
    await first.close()
    with contextlib.closing(sqlite3.connect(settings.data_dir / "library" / "library.db")) as database, database:
        database.execute("""UPDATE logs SET summary = replace(summary, '"scans"', '"n_of_scans"')""")
    second = make_library()
    await second.start()
    assert second.get("ann", record.id).summary is None
    await eventually(lambda: second.get("ann", record.id).public().scans == 7)


async def test_a_removed_folder_is_listed_as_empty(library: Library, settings: Settings) -> None:
    assert settings.logs_dir is not None
    settings.logs_dir.rmdir()
    assert [r.source for r in await library.list("ann")] == ["sample"]


async def test_the_sample_is_always_there(library: Library) -> None:
    record = next(r for r in await library.list("ann") if r.id == SAMPLE_ID)
    assert (record.name, record.source, record.state) == ("A simulated office (sample)", "sample", "ready")
    one, two = await asyncio.gather(library.load("ann", SAMPLE_ID), library.load("bob", SAMPLE_ID))
    assert one is two
    assert {"true", "odometry"} <= set(one.trajectories)
    with pytest.raises(LogReadOnlyError):
        await library.delete("ann", SAMPLE_ID)


async def test_listing_the_logs_starts_making_the_sample(library: Library) -> None:
    await library.list("ann")
    await eventually(lambda: library.get("ann", SAMPLE_ID).summary is not None)
    assert library.get("ann", SAMPLE_ID).public().scans == (await library.load("ann", SAMPLE_ID)).n_scans
