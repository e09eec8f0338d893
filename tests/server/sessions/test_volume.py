"""Sessions in 3D: a recording with point clouds is read on request, mapped scan by scan, asked and downloaded."""

from __future__ import annotations

import asyncio
import io
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyoctomap
import pytest
import trimesh

from mapper.io.clouds import read_cloud, read_depth_folder
from mapper.terrain import agreement, find_ground
from mapper.volume import OccupancyVolume, Octree, TsdfConfig, TsdfVolume, VolumeConfig, octree_file, surface_mesh
from mapper.volume.mesh.files import ply_bytes
from mapper.volume.scans.scan_sequence import ScanSequence, gather
from mapper.volume.scans.sources import Insertion, insert_all, open_source
from mapper.volume.surface.parameters import TSDF_PARAMETERS
from server.library.packs.volume import read_volume_pack, write_volume_pack
from server.parts.volume.cloud_points import CloudPoints
from server.parts.wire import command_of
from server.sessions.tick import TickResult
from tests.mapper.io.logs.recorded import written
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.server.library.small_logs import carmen
from tests.server.service import Service, Watcher, once_read, running, settings_for

DEPTH_ENDS = ("depth.png", "pose.txt")


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("volumes"))) as service:
        yield service


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("recording"), recording_of_room(), "mcap")


def uploaded(service: Service, path: Path) -> str:
    answer = service.http.put("/api/logs", params={"name": path.name}, content=path.read_bytes())
    assert answer.status_code == 202, answer.text
    log = once_read(service.http, answer.json()["id"])
    assert log["state"] == "ready", log["error"]
    return str(log["id"])


async def test_the_map_of_a_recording_is_that_of_the_library(service: Service, recording: Path, tmp_path: Path) -> None:
    log = await asyncio.to_thread(uploaded, service, recording)
    wanted = {"kind": "volume", "log": log, "playing": False}
    session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
    async with service.connect(session) as socket:
        page = Watcher(socket)
        await page.until(lambda: {"volume", "frame"} <= page.newest.keys())
        hello = page.newest["hello"]
        resolution = 0.2
        await page.send("parameters", values={"resolution": resolution})
        await page.until(lambda: page.newest.get("parameters", hello["parameters"])["values"]["resolution"] == 0.2)
        assert (hello["kind"], page.newest["frame"]["count"]) == ("volume", 4)
        for index in (3, 1, 4):  # forward, back, forward
            await page.send("seek", index=index)
            await page.until(lambda index=index: page.newest["frame"]["index"] == index)  # type: ignore[misc]
        await page.until(lambda: page.newest["volume"]["nodes"] is not None)
        result = TickResult()
        service.state.sessions.get(session).model.handle(command_of({"type": "seek", "index": 4}), result)
        assert not result.changed  # it is there
        expected = OccupancyVolume(VolumeConfig(resolution=resolution))
        insert_all(expected, open_source(recording), Insertion())
        tree = Octree.of(expected)
        found = page.newest["volume"]
        assert (found["occupied"], found["free"]) == expected.count_states()
        assert found["nodes"] == tree.n_nodes
        for kind in ("bt", "ot"):
            answer = await asyncio.to_thread(service.http.get, f"/api/sessions/{session}/volume.{kind}")
            assert answer.content == octree_file(tree, f".{kind}", expected.config).bytes(expected.config)

        keys, values = expected.voxels()
        k = int(np.argmax(values))
        x, y, z = ((keys[k] - 32768 + 0.5) * resolution).tolist()
        await page.send("voxel", x=x, y=y, z=z)
        why = await page.answer("voxel")
        assert why["log_odds"] == pytest.approx(float(values[k]))
        assert (why["state"], why["hits"], why["total"]) == ("occupied", len(why["updates"]), len(why["updates"]))
        assert why["updates"][-1]["after"] == pytest.approx(float(values[k]))

        # Kept, gone back, and compared: what the later scans added is gone.
        await page.send("volume_keep")
        await page.send("seek", index=1)
        await page.until(lambda: (page.newest["volume"]["compared"] or {}).get("only_first", 0) > 0)
        compared = page.newest["volume"]["compared"]
        assert compared["title"] == "the map of 4 scans"
        assert (compared["only_second"], compared["appeared"] + compared["same"] > 0) == (0, True)

        # A resolution that would take all memory is refused in a sentence, and the session goes on.
        await page.send("parameters", values={"resolution": 0.001})
        error = await page.answer("error")
        assert error["code"] in ("volume.too_large", "volume.scan_too_large")
        assert "coarser resolution" in error["message"]
        await page.send("parameters", values={"resolution": 0.5})
        await page.send("seek", index=4)
        await page.until(lambda: page.newest["frame"]["index"] == 4)
    octree = tmp_path / "kept.ot"
    octree.write_bytes(octree_file(tree, ".ot", expected.config).bytes(expected.config))
    assert pyoctomap.OcTree(resolution).read(str(octree)).size() == tree.n_nodes
    log = await asyncio.to_thread(uploaded, service, octree)
    # A request for a log, as an address written by hand makes it, opens it in 3D.
    made = (await asyncio.to_thread(service.http.post, "/api/sessions", json={"kind": "log", "log": log})).json()
    assert made["kind"] == "volume"
    answer = await asyncio.to_thread(service.http.get, f"/api/sessions/{made['id']}/volume.ot")
    assert answer.content == octree.read_bytes()


def test_what_is_packed_is_what_was_read(recording: Path, tmp_path: Path) -> None:
    scans = gather(recording)
    write_volume_pack(scans, tmp_path / "a.npz")
    again = read_volume_pack(tmp_path / "a.npz")
    assert isinstance(again, ScanSequence)
    for name in ("points", "starts", "origins", "stamps_ns", "offset"):
        np.testing.assert_array_equal(getattr(again, name), getattr(scans, name))
    assert (again.kind, again.notes) == (scans.kind, scans.notes)


def test_a_log_without_clouds_makes_no_map_in_3d(service: Service, tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_bytes(carmen(3))
    log = uploaded(service, path)
    answer = service.http.post("/api/sessions", json={"kind": "volume", "log": log})
    assert (answer.status_code, answer.json()["code"]) == (422, "clouds.none")


async def test_a_surface_follows_the_timeline_and_its_parameters_and_is_downloaded(
    service: Service, tmp_path: Path, data_file: Callable[[str], Path]
) -> None:
    folder = data_file("depth/camera-intrinsics.txt").parent
    path = tmp_path / "room.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for file in [folder / "camera-intrinsics.txt", *sorted(folder.glob("frame-0000*"))]:
            archive.write(file, file.name)
    log = await asyncio.to_thread(uploaded, service, path)
    wanted = {"kind": "volume", "log": log, "playing": False, "up": "z"}
    session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
    expected = TsdfVolume(TsdfConfig(resolution=0.05))
    depth = read_depth_folder(folder)
    for frame in depth.frames[:3]:
        expected.fuse_depth(frame.read(), depth.camera, frame.pose)
    async with service.connect(session) as socket:
        page = Watcher(socket)
        await page.until(lambda: {"surface", "frame"} <= page.newest.keys())
        assert page.newest["surface"]["index"] == 0
        assert len(page.newest["surface"]["table"]) == len(TSDF_PARAMETERS)
        await page.send("surface", values={"resolution": 0.05})
        await page.send("volume_look", values={"show": "surface"})

        async def shown(index: int) -> dict[str, Any]:
            await page.send("seek", index=index)

            def is_drawn() -> bool:
                now = page.newest["surface"]
                return (page.newest["frame"]["index"], now["index"], now["pending"]) == (index, index, 0)

            await page.until(is_drawn)
            return page.newest["surface"]

        first = (await shown(1))["triangles"]
        whole = surface_mesh(expected)
        assert (await shown(3))["triangles"] == len(whole.triangles) > first > 0
        answer = await asyncio.to_thread(service.http.get, f"/api/sessions/{session}/surface.ply")
        assert answer.content == ply_bytes(whole)
        answer = await asyncio.to_thread(service.http.get, f"/api/sessions/{session}/surface.glb")
        read = trimesh.load_mesh(io.BytesIO(answer.content), file_type="glb", process=False)
        assert len(read.faces) == len(whole.triangles)
        assert (await shown(1))["triangles"] == first

        # A ray along the optical axis of the first image meets what is seen there.
        pose = depth.frames[0].pose
        await page.send("voxel_ray", origin=pose[:3, 3].tolist(), direction=pose[:3, 2].tolist())
        why = await page.answer("surface_voxel")
        assert (why["index"], why["total"], why["updates"][0]["scan"]) == (1, 1, 1)
        assert abs(why["distance"]) <= 0.05 * np.sqrt(3.0)
        assert why["updates"][0]["measured"] == why["distance"] == why["updates"][0]["after"]

        await page.send("surface", values={"truncation": 0.05})
        assert (await page.answer("error"))["code"] == "parameter.truncation"
        await page.send("surface", values={"truncation": 0.11})
        await page.until(lambda: page.newest["surface"]["truncation"] == 0.11 and page.newest["surface"]["index"] == 1)
        assert 0 < page.newest["surface"]["triangles"] < first


def test_depth_images_are_packed_as_they_were_read(tmp_path: Path, data_file: Callable[[str], Path]) -> None:
    whole = data_file("depth/camera-intrinsics.txt").parent
    folder = tmp_path / "two"
    folder.mkdir()
    for name in ("camera-intrinsics.txt", *(f"frame-000{k}.{end}" for k in ("000", "480") for end in DEPTH_ENDS)):
        (folder / name).symlink_to(whole / name)
    scans = gather(folder)
    assert scans.first_up == "-y", "the frame of 7-Scenes is that of its first image, whose y points down"
    assert scans.with_up("-y").first_up == "z"
    write_volume_pack(scans, tmp_path / "a.npz")
    again = read_volume_pack(tmp_path / "a.npz")
    assert isinstance(again, ScanSequence)
    assert scans.depth is not None
    assert again.depth is not None
    assert (again.depth.camera, again.depth.unit) == (scans.depth.camera, scans.depth.unit)
    np.testing.assert_array_equal(again.depth.images, scans.depth.images)
    for k, frame in enumerate(read_depth_folder(folder).frames):
        np.testing.assert_array_equal(np.nan_to_num(frame.read()), again.depth.depth(k))
        np.testing.assert_array_equal(frame.pose, again.depth.poses[k])


async def test_the_ground_of_a_cloud_is_judged_by_a_file_of_its_ground_points(
    service: Service, data_file: Callable[[str], Path]
) -> None:
    """A real sample with its truth: kappa as the library has it; another cloud is no truth, and says so by null."""
    path = data_file("pointclouds/samp21-utm.pcd")
    true = data_file("pointclouds/samp21-utm-ground.pcd")
    other = data_file("pointclouds/samp24-utm.pcd")
    logs = [await asyncio.to_thread(uploaded, service, one) for one in (path, true, other)]
    points = read_cloud(path).points
    places = {place.tobytes() for place in read_cloud(true).points}
    expected = agreement(find_ground(points).is_ground, np.array([place.tobytes() in places for place in points]))
    for second, truth, kappa in ((logs[1], true.name, expected["kappa"]), (logs[2], None, None)):
        wanted = {"kind": "volume", "log": logs[0], "other": second}
        session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
        async with service.connect(session) as socket:
            page = Watcher(socket)
            await page.until(lambda page=page: "terrain" in page.newest)  # type: ignore[misc]
            await page.send("terrain")
            await page.until(lambda page=page: page.newest["terrain"]["points"] == len(points))  # type: ignore[misc]
            said = page.newest["terrain"]
        assert said["truth"] == truth
        assert said["kappa"] == (None if kappa is None else pytest.approx(kappa, abs=0.1))


def test_the_classes_of_a_file_are_the_truth_of_its_ground() -> None:
    points = np.random.default_rng(0).uniform(0.0, 9.0, (100, 3)).astype(np.float32)
    low, high = np.zeros(3), np.full(3, 9.0)

    def of(classes: np.ndarray) -> CloudPoints:
        whole, nowhere = np.array([0, 100]), np.full((1, 3), np.nan)
        scans = ScanSequence("las", points, whole, nowhere, np.zeros(1, np.int64), np.zeros(3), {"class": classes})
        return CloudPoints(scans, low, high)

    known = of(np.where(np.arange(100) < 60, 2, 6))
    _, _, ground = known.read()
    assert ground is not None
    assert (known.truth, ground.tolist()) == ("the file’s classes", [k < 60 for k in range(100)])
    unclassified = of(np.zeros(100, dtype=np.int64))
    assert (unclassified.truth, unclassified.read()[2]) == (None, None)
