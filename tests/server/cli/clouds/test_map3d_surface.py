"""``gridbloom map3d`` writes meshes, of surfaces and of voxels, and ``info`` describes them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from tests.server.cli.running import Run

GRAPH = "NODE 0.05 0.05 0.05 0 0 0\n1.0 0 0\n1.1 0 0\n0 1.0 0.5\n"


def depth_folder(folder: Path) -> Path:
    """A wall 1 m ahead of a camera that looks along z."""
    folder.mkdir()
    Image.fromarray(np.full((60, 80), 1000, dtype=np.uint16)).save(folder / "frame-000000.depth.png")
    np.savetxt(folder / "frame-000000.pose.txt", np.eye(4))
    (folder / "camera-intrinsics.txt").write_text("70 0 39.5\n0 70 29.5\n0 0 1\n")
    return folder


def test_a_depth_folder_becomes_a_mesh_that_info_describes(run: Run, tmp_path: Path) -> None:
    out = [tmp_path / "wall.ply", tmp_path / "wall.glb"]
    status, said, err = run(
        "map3d", depth_folder(tmp_path / "frames"), "--tsdf", "--resolution", "0.05", "--truncation", "0.15",
        "--max-weight", "8", "--out", out[0], "--out", out[1], "--json",
    )  # fmt: skip
    assert status == 0, err
    facts = json.loads(said)
    assert (facts["scans"], facts["used"], facts["truncation"]) == (1, 4800, 0.15)
    read: Any = trimesh.load(out[0], process=False)
    np.testing.assert_allclose(read.vertices[:, 2], 1.0, atol=1e-5)
    assert len(read.faces) == facts["triangles"] > 100
    solid: Any = trimesh.load(out[1], force="mesh")
    assert abs(solid.area - read.area) < 1e-5
    described = json.loads(run("info", out[0], "--json").out)
    assert (described["format"], described["triangles"], described["normals"]) == ("PLY mesh", len(read.faces), True)
    assert abs(described["area_m2"] - read.area) < 1e-3
    assert "triangles of" in run("info", out[0]).out


def test_a_scan_graph_becomes_a_surface_and_a_box_mesh(run: Run, tmp_path: Path) -> None:
    graph, boxes = tmp_path / "scan.graph", tmp_path / "boxes.ply"
    graph.write_text(GRAPH)
    assert run("map3d", graph, "--tsdf", "--resolution", "0.1", "--out", tmp_path / "thin.ply").status == 0
    assert run("map3d", graph, "--resolution", "0.1", "--out", boxes, "--out", tmp_path / "a.bt").status == 0
    read: Any = trimesh.load(boxes, process=False)
    # Two voxels side by side are one box of six rectangles, the third voxel is another box.
    assert len(read.faces) == 24
    assert abs(read.area - 0.01 * (10 + 6)) < 1e-6
    solid = trimesh.Trimesh(read.vertices.round(6), read.faces)
    assert solid.is_watertight
    assert solid.volume > 0.0
    again = tmp_path / "again.glb"
    assert run("map3d", tmp_path / "a.bt", "--out", again).status == 0
    boxed: Any = trimesh.load(again, force="mesh")
    assert len(boxed.faces) == 24


def test_bad_input_is_one_sentence(run: Run, tmp_path: Path) -> None:
    graph, ply = tmp_path / "scan.graph", tmp_path / "a.ply"
    graph.write_text(GRAPH)
    frames = depth_folder(tmp_path / "frames")
    cloud = tmp_path / "cloud.xyz"
    cloud.write_text("1 0 0\n2 0 0\n3 0 0\n")
    assert run("map3d", graph, "--resolution", "0.1", "--out", ply).status == 0
    whole = ply.read_bytes()
    cut, wrong = tmp_path / "cut.ply", tmp_path / "wrong.ply"
    cut.write_bytes(whole[:-5])
    wrong.write_bytes(whole[:-4] + b"\xff\xff\xff\x7f")
    for arguments, said in (
        (("map3d", graph, "--tsdf", "--out", tmp_path / "a.bt"), "--out must end in .ply or .glb with --tsdf"),
        (("map3d", graph, "--out", tmp_path / "a.las"), "--out must end in .bt, .ot, .ply or .glb, not 'a.las'"),
        (("map3d", graph, "--truncation", "1", "--out", ply), "--truncation is of surfaces: it needs --tsdf"),
        (("map3d", graph, "--tsdf", "--half-life", "3", "--out", ply), "--half-life is of occupied voxels"),
        (("map3d", graph, "--tsdf", "--map", tmp_path / "m", "--out", ply), "--map and --band are of occupied voxels"),
        (("map3d", graph, "--tsdf", "--truncation", "0.03", "--out", ply), "less than two voxels"),
        (("map3d", frames, "--tsdf", "--resolution", "1e-9", "--out", ply), "Resolution (resolution) must be between"),
        (("map3d", cloud, "--tsdf", "--out", ply), "does not say where the sensor was"),
        (("map3d", frames, "--tsdf", "--range-max", "0.5", "--out", ply), "no point that is finite"),
        (("info", cut), "its header says 24 faces"),
        (("info", wrong), "names a vertex that is not among"),
    ):
        status, _, err = run(*arguments)
        assert status == 2, arguments
        assert said in err
        assert err.count("\n") == 1
    (frames / "frame-000000.pose.txt").write_text("2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n")
    assert "not a rotation" in run("map3d", frames, "--tsdf", "--out", ply).err
    np.savetxt(frames / "frame-000000.pose.txt", np.eye(4))
    Image.fromarray(np.full((6, 8), 1000, dtype=np.uint16)).save(frames / "frame-000001.depth.png")
    np.savetxt(frames / "frame-000001.pose.txt", np.eye(4))
    assert "8 × 6 pixels has intrinsics for 80 × 60" in run("map3d", frames, "--tsdf", "--out", ply).err
