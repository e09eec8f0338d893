"""Files of the 3D view: bytes of voxels, and processor time of a depth image's surface up to its files."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np

from mapper.io.clouds import read_cloud, read_depth_folder
from mapper.sensors.depth_image import DepthFolder
from mapper.volume import TsdfConfig, TsdfVolume, VolumeConfig
from mapper.volume.mesh.chunk_mesh import ChunkMesh
from mapper.volume.mesh.faces import ChunkKey, VoxelFaces, chunks_of, face_rule
from mapper.volume.mesh.surface_chunks import SurfaceChunks
from mapper.volume.scans.replayed import ReplayedVolume
from mapper.volume.scans.scan_sequence import ScanSequence, gather
from server.parts.volume.look import COLOURS, HEIGHT_RAMP, Look
from server.parts.volume.start import bounds_of, first_look, first_resolution
from server.parts.volume.surface import height_colors
from server.scenes.drawers.chunks import surface_glb
from server.scenes.viser_server import Compressor
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from tests.mapper.volume.moving_lidar import record

ROUNDS = 5
CLOUDS = ("pointclouds/room_scan1.pcd", "pointclouds/pointmatcher-cloud.00000.vtk.gz", "pointclouds/source.ply",
          "pointclouds/samp11-utm.pcd", "octomap/spherical_scan.graph")  # fmt: skip


def packed(files: list[bytes]) -> int:
    """Return the bytes of files in one message, as the scene's server packs them."""
    return len(Compressor(0).compress(msgspec.msgpack.encode(files)))


def voxels_row(name: str, source: ScanSequence) -> str:
    """Return the row of a cloud: its scans one by one, and the whole."""
    low, high = bounds_of(source)
    resolution = first_resolution(source, low, high)
    now, faces = ReplayedVolume(source, VolumeConfig(resolution=resolution)), VoxelFaces()
    look = first_look(low, high, resolution)
    rule = face_rule(
        now.volume, look.low, look.high, base=float(low[2]), band=look.band, colours=COLOURS,
        seen_only=source.has_origins,
    )  # fmt: skip
    colors, changes = face_colors(HEIGHT_RAMP), []
    for index in range(1, now.count + 1):
        now.go_to(index)
        touched = now.take_touched()
        changed = faces.update(now.volume, rule, chunks_of(now.volume, touched))
        changes.append(packed([voxel_chunk(faces.chunks[key], colors) for key in changed if key in faces.chunks]))
    whole = packed([voxel_chunk(quads, colors) for quads in faces.chunks.values()])
    voxels = sum(faces.voxels.values())
    change = f"{np.median(changes[1:]) / 1000:.0f}, {max(changes[1:]) / 1000:.0f}" if now.count > 1 else "–"
    return (
        f"| {name} | {100 * resolution:g} cm | {now.count} | {voxels:,} | {whole / 1000:.0f} | {whole / voxels:.1f} | "
        f"{change} |"
    )


def voxels(data: Path) -> None:
    """Print a row for each cloud, and for a room that a moving sensor measures a quarter of at a time."""
    print("\nVoxels as they are sent")
    print("| cloud | voxels | scans | drawn voxels | kB | B a voxel | kB of a scan's change: median, greatest |")
    print("|---|---|---|---|---|---|---|")
    for name in CLOUDS:
        if not (data / name).is_file():
            print(f"{name}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
            continue
        print(voxels_row(Path(name).name, gather(data / name)), flush=True)
    room = read_cloud(data / CLOUDS[0]).points
    room = room[np.isfinite(room).all(axis=1)]
    with TemporaryDirectory() as folder:
        run = record(Path(folder), np.random.default_rng(0).permutation(room), "bag")
        print(voxels_row("the room, measured in four scans", gather(run.path)), flush=True)


def surface_row(folder: DepthFolder, resolution: float) -> str:
    """Return the row of one size of voxels: of each step the median of the images, the least of some rounds."""
    frames = [(frame.read(), frame.pose) for frame in folder.frames]
    rounds = np.array([_images(folder, frames, resolution) for _ in range(ROUNDS + 1)])[1:]
    times = np.median(rounds[:, :, :4].min(axis=0), axis=0)
    triangles, sent = np.median(rounds[0, :, 4:], axis=0)
    each = " | ".join(f"{ms:.1f}" for ms in (*times, times.sum()))
    return f"| {100 * resolution:g} cm | {each} | {triangles:.0f} | {sent / 1000:.0f} |"


def _images(folder: DepthFolder, frames: list[tuple[np.ndarray, np.ndarray]], resolution: float) -> list[list[float]]:
    """Return of each image the ms of fusing, meshing, writing and packing, the triangles and the bytes."""
    volume, chunks, look = TsdfVolume(TsdfConfig(resolution=resolution)), SurfaceChunks(), Look()
    shown: dict[ChunkKey, ChunkMesh] = {}
    rows = []
    for depth, pose in frames:
        at = [time.process_time()]
        did = volume.fuse_depth(depth, folder.camera, pose)
        at.append(time.process_time())
        chunks.note_change(volume, did.slots)
        chunks.work(volume)
        at.append(time.process_time())
        new = {key: mesh for key, mesh in chunks.chunks.items() if shown.get(key) is not mesh}
        shown = dict(chunks.chunks)
        files = [surface_glb(mesh, height_colors(key, mesh, resolution, -1.0, look)) for key, mesh in new.items()]
        at.append(time.process_time())
        sent = packed(files)
        at.append(time.process_time())
        rows.append([*(1e3 * np.diff(at)), sum(len(mesh.triangles) for mesh in new.values()), sent])
    return rows


def chunk_files() -> None:
    """Print both tables."""
    data = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    voxels(data)
    print("\nA depth image up to the files of the chunks that it changes, ms of processor time")
    print("| voxels | fused | meshed | written | packed | all | triangles | kB |\n|---|---|---|---|---|---|---|---|")
    folder = read_depth_folder(data / "depth")
    for resolution in (0.02, 0.01):
        print(surface_row(folder, resolution), flush=True)
