"""The part of ``python -m tests.bench tsdf`` that runs in a Python with Open3D; arguments are files in one folder.

``fuse FRAMES RESOLUTION VOXELS MESH``: fuse the frames, mesh, write the mesh, print the processor times as JSON.
``errors POINTS MESH...``: print the mean and the 95th percentile of the distances from points to each mesh, mm.
"""

# mypy: ignore-errors

from __future__ import annotations

import json
import sys
import time

import numpy as np
import open3d as o3d
import open3d.core as o3c


def fuse(frames: str, resolution: str, voxels: str, out: str) -> dict[str, float]:
    held = np.load(frames)
    camera = o3c.Tensor(held["camera"])
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight"), (o3c.float32, o3c.float32), ((1), (1)), float(resolution), 16, 20_000, o3c.Device("CPU:0")
    )
    images = [o3d.t.geometry.Image(o3c.Tensor(one)) for one in held["depths"]]
    places = [o3c.Tensor(np.linalg.inv(pose)) for pose in held["poses"]]
    began = time.process_time()
    for image, place in zip(images, places, strict=True):
        blocks = grid.compute_unique_block_coordinates(image, camera, place, 1.0, 20.0, float(voxels))
        grid.integrate(blocks, image, camera, place, 1.0, 20.0, float(voxels))
    fused = time.process_time()
    mesh = grid.extract_triangle_mesh(weight_threshold=0.0)
    ended = time.process_time()
    vertices, triangles = mesh.vertex.positions.numpy(), mesh.triangle.indices.numpy()
    np.savez(out, vertices=vertices, triangles=triangles)
    return {
        "fuse": 1e3 * (fused - began) / len(images), "mesh": 1e3 * (ended - fused), "triangles": len(triangles),
    }  # fmt: skip


def errors(points: str, *meshes: str) -> list[tuple[float, float]]:
    some = o3c.Tensor(np.load(points))
    found = []
    for name in meshes:
        held = np.load(name)
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(
            o3c.Tensor(held["vertices"].astype(np.float32)), o3c.Tensor(held["triangles"].astype(np.uint32))
        )
        away = 1e3 * scene.compute_distance(some).numpy()
        found.append((float(away.mean()), float(np.percentile(away, 95))))
    return found


print(json.dumps({"fuse": fuse, "errors": errors}[sys.argv[1]](*sys.argv[2:])))
