"""Uploads of map files: what is one, what is in it, and what is refused."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.editing import EditedMap, parse_operation
from mapper.editing.files import map_files
from mapper.grid import GridGeometry
from mapper.io.costmaps import CostmapStream, RecordedCostmap
from server.downloads import file_stem
from server.jobs.leases import Leases
from server.library.logs.records import LogNotFoundError
from server.library.packs.costmaps import costmap_codes
from server.library.packs.map import map_codes, summarise_map
from server.library.packs.map_files import archived, is_map, read_map
from server.library.packs.reference_map import ReferenceMap, read_reference_map
from server.library.processing.reference_maps import ReferenceMaps
from server.library.store.common_files import CommonFiles
from server.library.store.known_paths import KnownPaths
from server.storage import StorageError

GEOMETRY = GridGeometry(0.1, 4, 6, (1.0, -2.0, 0.5))
VALUES = np.array([[0, 100, -1, 0, 0, 40]] * 4, np.int8)
ZONE = {"op": "keepout", "polygon": [[-9, -9], [9, -9], [9, 9], [-9, 9]], "value": 60}


def files_of(name: str = "room") -> dict[str, bytes]:
    edited = EditedMap(GEOMETRY, VALUES)
    edited.apply(parse_operation(ZONE))
    edited.apply(parse_operation(ZONE | {"op": "speed", "value": 35}))
    return dict(map_files(edited, name, "old.yaml"))


def upload(folder: Path, files: dict[str, bytes]) -> Path:
    path = folder / "upload"
    path.write_bytes(archived(files.items()))
    return path


def test_a_map_is_read_with_its_mask_and_what_made_it(tmp_path: Path) -> None:
    source = upload(tmp_path, files_of())
    assert is_map(source)
    found = read_map(source, "map", tmp_path)
    np.testing.assert_array_equal(found.values, VALUES)
    assert found.keepout is not None
    assert (found.keepout == 60).all()
    assert found.speed is not None
    assert (found.speed == 35).all()
    assert found.notes[-1] == "Made by 2 edits of 'old.yaml'."
    found.write(tmp_path / "pack")
    again = read_reference_map(tmp_path / "pack")
    np.testing.assert_array_equal(again.keepout, found.keepout)
    np.testing.assert_array_equal(again.speed, found.speed)
    assert (again.geometry, again.notes) == (found.geometry, found.notes)
    said = summarise_map(found)
    assert said.map is not None
    assert (said.format, said.map.rows, said.map.cols, said.scans) == ("map", 4, 6, 0)
    assert map_codes(found).tolist() == [[1, 2, 0, 1, 1, 0]] * 4


def test_a_map_of_a_long_name_is_read_back(tmp_path: Path) -> None:
    name = "план этажа " * 10
    found = read_map(upload(tmp_path, files_of(file_stem(name))), "map", tmp_path)
    assert found.title == f"{file_stem(name)}.yaml"
    assert found.keepout is not None


def test_a_picture_of_a_large_map_keeps_its_walls() -> None:
    values = np.full((1000, 700), -1, np.int8)
    values[10, 20], values[999, 699] = 100, 0
    codes = map_codes(ReferenceMap("large", GridGeometry(0.05, 1000, 700), values))
    assert codes.shape == (250, 175)
    assert (codes[-1 - 10 // 4, 20 // 4], codes[0, -1], (codes > 0).sum()) == (2, 1, 2)


@pytest.mark.parametrize(
    ("files", "is_one"),
    [
        ({"a.yaml": b"", "a.pgm": b""}, True),
        ({"a.yaml": b""}, False),
        ({"a.pgm": b""}, False),
        ({"metadata.yaml": b"", "run_0.db3": b""}, False),
        ({"a.yaml": b"", "a.pgm": b"", "notes.txt": b""}, False),
        ({f"{k}.pgm": b"" for k in range(20)} | {"a.yaml": b""}, False),
    ],
)
def test_what_is_a_map(tmp_path: Path, files: dict[str, bytes], is_one: bool) -> None:
    assert is_map(upload(tmp_path, files)) is is_one


def test_what_is_refused(tmp_path: Path) -> None:
    (tmp_path / "upload").write_bytes(b"no archive")
    assert not is_map(tmp_path / "upload")
    room, other = files_of(), {"other.yaml": files_of("other")["other.yaml"]}
    small = dict(map_files(EditedMap(GridGeometry(0.1, 2, 2), np.zeros((2, 2), np.int8)), "small"))
    mask = {
        "room_keepout.yaml": small["small.yaml"].replace(b"small", b"room_keepout"),
        "room_keepout.pgm": small["small.pgm"],
    }
    for files, said in (
        (room | other, "there are 4 yamls here"),
        (room | {"room_speed.pgm": b"P5 no numbers"}, "The map’s image 'room_speed.pgm' is damaged"),
        (room | {"room_speed.yaml": b"image: room_speed.pgm"}, "resolution"),
        (room | mask, "'room_keepout.yaml' has other cells than the map 'room.yaml'"),
        ({"room.yaml": room["room.yaml"], "else.pgm": room["room.pgm"]}, "room.pgm"),
    ):
        with pytest.raises(ReadError, match=said):
            read_map(upload(tmp_path, files), "map", tmp_path)


def test_names_in_an_archive_are_no_paths_and_fit_into_a_folder(tmp_path: Path) -> None:
    path, files = tmp_path / "upload", files_of()
    with tarfile.open(path, "w", format=tarfile.PAX_FORMAT) as archive:
        for name, data in files.items():
            member = tarfile.TarInfo(f"../{name}")
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
        archive.addfile(tarfile.TarInfo("somewhere/.."))
    assert is_map(path)
    assert read_map(path, "map", tmp_path).title == "room.yaml"
    assert [*tmp_path.iterdir()] == [path]
    with tarfile.open(path, "w", format=tarfile.PAX_FORMAT) as archive:
        archive.addfile(tarfile.TarInfo("é" * 150 + ".yaml"))
    with pytest.raises(ReadError, match="too long"):
        read_map(path, "map", tmp_path)


def test_an_archive_of_endless_names_is_no_map(tmp_path: Path) -> None:
    # tarfile calls itself for each record of a name.
    name = tarfile.TarInfo("name")
    name.type, name.size = tarfile.GNUTYPE_LONGNAME, 5
    (tmp_path / "upload").write_bytes((name.tobuf(tarfile.GNU_FORMAT) + b"name\0".ljust(512, b"\0")) * 3000)
    assert not is_map(tmp_path / "upload")


def test_the_picture_of_recorded_costmaps_has_their_obstacles() -> None:
    stream = CostmapStream("/costmap_raw")
    for k, cost in enumerate((0, 254, 0)):
        costs = np.zeros((2, 3), np.uint8)
        costs[0, 0], costs[1, 2] = cost, 255
        stream.add(RecordedCostmap(k, k, "odom", "master", GridGeometry(0.1, 2, 3), costs))
    assert costmap_codes({"/costmap_raw": stream}).tolist() == [[1, 1, 0], [2, 1, 1]]


async def test_no_map_is_kept_for_a_log_that_was_deleted_meanwhile(tmp_path: Path) -> None:
    class Logs:
        is_deleted = False

        def get(self, owner: str, log_id: str) -> None:
            if self.is_deleted:
                raise LogNotFoundError("log.unknown", "There is no such log.")

        async def reference_map(self, owner: str, log_id: str) -> ReferenceMap:
            self.is_deleted = True
            return ReferenceMap("room", GEOMETRY, VALUES)

    maps = ReferenceMaps(Logs(), lambda: None, tmp_path / "maps", lambda: 1 << 20, CommonFiles(Leases(None, 5.0), None))  # type: ignore[arg-type,return-value]
    with pytest.raises(LogNotFoundError):
        await maps.of_log("somebody", "log", "map", None, None)
    assert (maps.total_bytes, [*(tmp_path / "maps").iterdir()]) == (0, [])


def test_a_folder_with_a_dot_in_its_name_is_called_a_folder(tmp_path: Path) -> None:
    (folder := tmp_path / "my.data").mkdir()
    standing = KnownPaths([folder])
    standing.check()
    folder.rename(tmp_path / "moved")
    with pytest.raises(StorageError, match="folder was moved"):
        standing.check()
