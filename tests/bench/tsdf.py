"""Fusing depth images and meshing the surface beside Open3D's VoxelBlockGrid; in processor time over all threads.

Open3D is measured where ``GRIDBLOOM_OPEN3D`` names a Python that has it (``pip install open3d-cpu`` in an environment
of its own), in the same run and in turns; it also measures the distances from the depth images' points to both meshes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from mapper.core.errors import ReadError
from mapper.io.clouds import read_depth_folder
from mapper.sensors.depth_image import DepthFolder
from mapper.volume import Mesh, TsdfConfig, TsdfVolume, surface_mesh
from mapper.volume.mesh.meshing import blocks_of_change
from mapper.volume.surface.parameters import TRUNCATION_VOXELS
from tests.bench.surface_socket import surface_socket_row

Frames = list[tuple[np.ndarray, np.ndarray]]
PEER = Path(__file__).with_name("open3d_peer.py")
ROUNDS = 5


def ours(folder: DepthFolder, frames: Frames, config: TsdfConfig) -> tuple[dict[str, float], Mesh]:
    """Return the times of one round in ms: an image, the mesh of all, and an image and the mesh of what it changed."""
    volume = TsdfVolume(config)
    began = time.process_time()
    for depth, pose in frames:
        volume.fuse_depth(depth, folder.camera, pose)
    fused = time.process_time()
    mesh = surface_mesh(volume)
    ended = time.process_time()
    walls = []
    for depth, pose in frames:
        start = time.perf_counter()
        did = volume.fuse_depth(depth, folder.camera, pose)
        surface_mesh(volume, blocks_of_change(volume, did.slots))
        walls.append(time.perf_counter() - start)
    times = {
        "fuse": 1e3 * (fused - began) / len(frames),
        "mesh": 1e3 * (ended - fused),
        "change": 1e3 * float(np.median(walls)),
    }
    return times, mesh


def peer(*arguments: object) -> Any:
    """Return what the peer prints; None where there is none."""
    python = os.environ.get("GRIDBLOOM_OPEN3D")
    if python is None:
        return None
    command = [python, str(PEER), *map(str, arguments)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1])


def tsdf() -> None:
    """Print a row for each size of voxels."""
    place = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")) / "depth"
    try:
        folder = read_depth_folder(place)
    except ReadError:
        print("depth: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
        return
    frames, camera = [(frame.read(), frame.pose) for frame in folder.frames], folder.camera
    print(f"\n{len(frames)} depth images of {camera.width} × {camera.height}, truncation four voxels; ms")
    print(f"of processor time, best of {ROUNDS} in turns; the change of one image, fused and meshed, is elapsed time")
    print("| voxels | | ours | Open3D | ratio |\n|---|---|---|---|---|")
    with TemporaryDirectory() as name:
        work = Path(name)
        np.savez(
            work / "frames.npz",
            depths=np.nan_to_num(np.stack([depth for depth, _ in frames])),
            poses=np.stack([pose for _, pose in frames]),
            camera=np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]),
        )
        points = [camera.points(depth)[::37] @ pose[:3, :3].T + pose[:3, 3] for depth, pose in frames]
        some = np.concatenate(points).astype(np.float32)
        np.save(work / "points.npy", some[np.isfinite(some).all(axis=1)])
        for resolution in (0.02, 0.01):
            _row(folder, frames, resolution, work)
    print("\nFrom a step on the session's page to the first and the last changed triangles at the socket of its 3D")
    print("view, elapsed ms: of each step the best of three rounds; least, median and greatest of all steps")
    print("| voxels | first triangles | last triangles | triangles that arrive | kB on the wire |")
    print("|---|---|---|---|---|")
    for resolution in (0.02, 0.01):
        print(surface_socket_row(place, resolution), flush=True)


def _row(folder: DepthFolder, frames: Frames, resolution: float, work: Path) -> None:
    config = TsdfConfig(resolution=resolution)
    _, mesh = ours(folder, frames, config)  # the kernels are loaded
    best: dict[str, float] = {}
    least: dict[str, float] = {}
    for _ in range(ROUNDS):
        mine, mesh = ours(folder, frames, config)
        best = {key: min(value, best.get(key, np.inf)) for key, value in mine.items()}
        theirs = peer("fuse", work / "frames.npz", resolution, TRUNCATION_VOXELS, work / "theirs.npz")
        least = {key: min(value, least.get(key, np.inf)) for key, value in (theirs or {}).items()}
    size = f"{100 * resolution:g} cm"
    for key, what in (("fuse", "an image"), ("mesh", "mesh of all")):
        other = f"{least[key]:.1f} | {least[key] / best[key]:.1f} ×" if least else "not measured | –"
        print(f"| {size} | {what} | {best[key]:.1f} | {other} |", flush=True)
    print(f"| {size} | change of an image | {best['change']:.0f} | – | – |")
    if not least:
        return
    np.savez(work / "ours.npz", vertices=mesh.vertices, triangles=mesh.triangles)
    errors = peer("errors", work / "points.npy", work / "ours.npz", work / "theirs.npz")
    said = [f"{mean:.2f}, 95 % below {high:.1f} mm" for mean, high in errors]
    print(f"| {size} | points to the mesh | {said[0]} | {said[1]} | {errors[1][0] / errors[0][0]:.2f} × |")
    print(f"| {size} | triangles | {len(mesh.triangles)} | {int(least['triangles'])} | – |", flush=True)
