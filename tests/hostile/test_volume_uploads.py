"""Malicious clouds, octrees and archives of depth images: each upload fails alone, with its own sentence."""

from __future__ import annotations

import asyncio
import io
import struct
import zipfile
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

import numpy as np
from PIL import Image

from mapper.volume import OccupancyVolume, Octree, VolumeConfig, octree_file
from tests.hostile.test_uploads import left, sent
from tests.server.service import Service, Watcher

Undisturbed = Callable[[Service], AbstractAsyncContextManager[Watcher]]
PCD = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT 1\nPOINTS %d\nDATA %s\n"
POSE = b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def pcd(*points: tuple[float, float, float], count: int | None = None) -> bytes:
    n = len(points) if count is None else count
    return PCD % (n, n, b"binary") + np.array(points, "<f4").tobytes()


def depth_png(width: int = 8, height: int = 6) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.full((height, width), 1000, np.uint16)).save(out, "PNG")
    return out.getvalue()


def zipped(**files: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name.replace("__", ".").replace("_dash_", "-"), data)
    return out.getvalue()


def tree(kind: str) -> bytes:
    volume = OccupancyVolume(VolumeConfig())
    volume.insert_scan(np.random.default_rng(0).normal(size=(50, 3)), np.zeros(3))
    return octree_file(Octree.of(volume), kind, volume.config).bytes(volume.config)


CAMERA = b"50 50 4 3"


def bad_files() -> dict[str, tuple[bytes, str]]:
    """Return files by what is wrong with them, each with a part of its sentence.

    A function, because volumes are made for it, which each worker would do while it collects the tests.
    """
    return {
        "a billion points claimed": (pcd((1, 2, 3), count=10**9), "more than the limit of 50000000"),
        "a PLY that claims a billion": (
            (b"ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n"
            b"end_header\n1 2 3\n"),
            "more than the limit of 50000000",
        ),
        "nothing but nan and infinite": (pcd((np.nan, 0, 0), (np.inf, 1, 1)), "is finite"),
        "no points": (PCD % (0, 0, b"binary"), "no points"),
        "coordinates of 1e30 m": (pcd((1e30, 0, 0)), "within 1e+08 m of the origin"),
        "a cut octree .bt": (tree(".bt")[:-2], "before its tree does"),
        "a cut octree .ot": (tree(".ot")[:-3], "before its tree does"),
        "an octree that says another size": (tree(".ot").replace(b"size ", b"size 1", 1), "nodes, but its tree has"),
        "a graph that ends early": (struct.pack("<III", 1, 1000, 3) + bytes(100), "end"),
        "a zip of other files": (zipped(holiday__jpg=b"a"), "holds no folder of depth images"),
        "a cut zip": (zipped(a__depth__png=depth_png(), a__pose__txt=POSE)[:-20], "damaged, ends early"),
        "a pose that is no rotation": (
            zipped(a__depth__png=depth_png(), a__pose__txt=POSE.replace(b"1", b"2", 1), camera__txt=CAMERA),
            "is not a rotation",
        ),
        "intrinsics of another size": (
            zipped(a__depth__png=depth_png(), a__pose__txt=POSE, camera__txt=b"500 500 320 240"),
            "of images of another size",
        ),
        "intrinsics in place of points": (b"585 0 320\n0 585 240\n0 0 1\n", "3 × 3 matrix of a camera’s intrinsics"),
        "a pose in place of points": (POSE, "4 × 4 matrix of a pose"),
        "a pose that is not finite": (
            zipped(a__depth__png=depth_png(), a__pose__txt=POSE.replace(b"1", b"nan", 1), camera__txt=CAMERA),
            "a.depth.png is not finite",
        ),
        "images of two sizes": (
            zipped(
                a__depth__png=depth_png(), a__pose__txt=POSE, b__depth__png=depth_png(9), b__pose__txt=POSE,
                camera__txt=CAMERA,
            ),
            "b.depth.png",
        ),
    }  # fmt: skip


async def test_each_bad_cloud_fails_alone_with_its_own_sentence(service: Service, undisturbed: Undisturbed) -> None:
    said, bad = set(), bad_files()
    async with undisturbed(service):
        for case, (data, sentence) in bad.items():
            log = await asyncio.to_thread(sent, service, data, "a.cloud")
            assert log["state"] == "failed", case
            message = log["error"]["message"]
            assert sentence in message, (case, message)
            assert message.endswith("."), message
            assert "/tmp" not in message, message
            said.add(message)
            wanted = {"kind": "volume", "log": log["id"]}
            opened = await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)
            assert (opened.status_code, opened.json()["message"]) == (422, message), case
            await asyncio.to_thread(service.http.delete, f"/api/logs/{log['id']}")
    assert len(said) >= len(bad) - 3
    assert left(service) == []


async def test_clouds_with_a_few_bad_points_and_far_away_ones_are_shown_without_them(service: Service) -> None:
    """Points that are not finite, 10⁷ m away, or beyond the lattice are counted, and the rest is mapped."""
    rng = np.random.default_rng(0)
    near = rng.uniform(0, 5, (500, 3))
    far = near + np.array([1e7, -1e7, 0.0])
    for points in (near, far.astype(np.float32)):
        data = pcd(*map(tuple, points), (np.nan, 1, 1), (4e7, 0, 0))
        log = await asyncio.to_thread(sent, service, data, "a.pcd")
        assert (log["state"], log["points"]) == ("ready", 501), log
        wanted = {"kind": "volume", "log": log["id"]}
        session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
        async with service.connect(session) as socket:
            page = Watcher(socket)
            await page.until(lambda page=page: page.newest.get("volume", {}).get("nodes") is not None)  # type: ignore[misc]
            assert page.newest["volume"]["left_out"] == 1
            assert page.newest["volume"]["occupied"] > 0


async def test_resolutions_that_would_take_all_memory_are_refused_and_the_map_stays(service: Service) -> None:
    """Voxels of 1 cm of a cloud 900 m wide, and patches of 1 cm of its terrain."""
    data = pcd(*map(tuple, np.random.default_rng(0).uniform(0, 900, (2000, 3)) * (1, 1, 0.01)))
    log = await asyncio.to_thread(sent, service, data, "a.pcd")
    wanted = {"kind": "volume", "log": log["id"]}
    session = (await asyncio.to_thread(service.http.post, "/api/sessions", json=wanted)).json()["id"]
    async with service.connect(session) as socket:
        page = Watcher(socket)
        await page.until(lambda page=page: page.newest.get("volume", {}).get("nodes") is not None)  # type: ignore[misc]
        before = page.newest["volume"]["occupied"]
        await page.send("parameters", values={"resolution": 0.01})
        await page.until(lambda page=page: page.newest.get("error") is not None)  # type: ignore[misc]
        assert "choose a coarser one" in page.newest["error"]["message"]
        assert page.newest["volume"]["occupied"] == before > 0
        await page.send("terrain", values={"patch": 0.01})
        await page.until(lambda page=page: page.newest["terrain"]["problem"] is not None)  # type: ignore[misc]
        assert "choose larger ones" in page.newest["terrain"]["problem"]
        await page.send("terrain", values={"patch": 100.0})
        await page.until(lambda page=page: page.newest["terrain"]["points"] == 2000)  # type: ignore[misc]
        assert page.newest["terrain"]["problem"] is None
