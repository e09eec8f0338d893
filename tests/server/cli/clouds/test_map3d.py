"""``gridbloom map3d``: octrees that OctoMap reads, and maps from above."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyoctomap
from scipy.spatial.transform import Rotation

from mapper.io.clouds import open_posed_clouds
from mapper.io.clouds.given_poses import GivenPoses
from mapper.io.maps import load_map
from mapper.volume import read_octree
from tests.mapper.io.logs.recorded import written
from tests.mapper.io.logs.recording.test_clouds import recording_of_room
from tests.server.cli.running import Run

GRAPH = "NODE 0.05 0.05 0.05 0 0 0\n1.0 0 0\n0 1.0 0.5\nnan 0 0\n"


def test_a_graph_becomes_octrees_and_a_map(run: Run, tmp_path: Path) -> None:
    graph = tmp_path / "scan.graph"
    graph.write_text(GRAPH)
    out = [tmp_path / "a.bt", tmp_path / "a.ot"]
    status, said, err = run(
        "map3d", graph, "--out", out[0], "--out", out[1], "--map", tmp_path / "above", "--band", "0,0.3", "--json"
    )
    assert status == 0, err
    facts = json.loads(said)
    assert (facts["scans"], facts["points"], facts["occupied"]) == (1, 2, 2)
    peer = pyoctomap.OcTree(1.0)
    assert peer.readBinary(str(out[0]))
    assert peer.getResolution() == 0.1
    assert peer.size() == facts["nodes"]
    assert peer.isNodeOccupied(peer.search([1.05, 0.05, 0.05]))
    above = load_map(tmp_path / "above.yaml").grid
    row, col = above.geometry.world_to_cell([[1.05, 0.05]])[0]
    assert above.log_odds[row, col] > 0.0

    again = tmp_path / "b.bt"
    assert run("map3d", out[0], "--out", again).status == 0
    assert again.read_bytes() == out[0].read_bytes()
    assert "a.bt: an octree, without scans of its own" in run("map3d", out[0], "--out", again).out
    status, said, _ = run("info", out[1], "--json")
    assert status == 0
    assert json.loads(said)["nodes"] == facts["nodes"]
    twice = run("map3d", out[1], graph, "--out", tmp_path / "c.ot", "--json")  # goes on with a map
    assert json.loads(twice.out)["occupied"] == 2


def test_bad_input_is_one_sentence(run: Run, tmp_path: Path) -> None:
    graph, tree = tmp_path / "scan.graph", tmp_path / "a.bt"
    graph.write_text(GRAPH)
    assert run("map3d", graph, "--out", tree).status == 0
    cut = tmp_path / "cut.bt"
    cut.write_bytes(tree.read_bytes()[:-3])
    for arguments, said in (
        ((graph, "--out", tmp_path / "a.las"), "--out must end in .bt, .ot, .ply or .glb, not 'a.las'"),
        ((graph, "--out", tree, "--resolution", "1e-9"), "Resolution (resolution) must be between"),
        ((tree, "--out", tree, "--resolution", "0.2"), "The voxels of a.bt are of 0.1 m, not 0.2 m"),
        ((cut, "--out", tree), "before its tree does"),
        ((tmp_path / "none.pcd", "--out", tree), "There is no file 'none.pcd'"),
        ((graph, "--out", tree, "--map", tmp_path / "m", "--band", "7,8"), "no known voxels between 7 and 8 m"),
    ):
        status, _, err = run("map3d", *arguments)
        assert status == 2
        assert said in err
        assert err.count("\n") == 1


def test_clouds_with_poses_beside_them_make_the_map_of_the_graph(run: Run, tmp_path: Path) -> None:
    """Two clouds in the frames of a turned and a moved sensor, as files with a TUM file and as a scan graph."""
    rng = np.random.default_rng(6)
    clouds = [rng.uniform(-2.0, 2.0, (300, 3)).round(3) for _ in range(2)]
    yaw = 0.5
    nodes = []
    for k, cloud in enumerate(clouds):
        np.savetxt(tmp_path / f"{k}.xyz", cloud, fmt="%.3f")
        lines = "\n".join(" ".join(f"{v:.3f}" for v in point) for point in cloud)
        nodes.append(f"NODE {k} 0.5 0.1 0 0 {k * yaw}\n{lines}\n")
    graph, poses = tmp_path / "scan.graph", tmp_path / "poses.tum"
    graph.write_text("".join(nodes))
    poses.write_text(
        f"# t x y z qx qy qz qw\n10 0 0.5 0.1 0 0 0 1\n11 1 0.5 0.1 0 0 {np.sin(yaw / 2):.12f} {np.cos(yaw / 2):.12f}\n"
    )
    files = [tmp_path / "0.xyz", tmp_path / "1.xyz"]
    ours, theirs = tmp_path / "a.ot", tmp_path / "b.ot"
    status, said, err = run("map3d", *files, "--poses", poses, "--out", ours, "--json")
    assert status == 0, err
    facts = json.loads(said)
    assert (facts["scans"], facts["points"]) == (2, 600)
    assert run("map3d", graph, "--out", theirs).status == 0
    a, b = (read_octree(path).tree.leaves() for path in (ours, theirs))
    same = set(map(tuple, a[0][a[2] > 0].tolist())) & set(map(tuple, b[0][b[2] > 0].tolist()))
    assert len(same) > 0.99 * (b[2] > 0).sum()
    surface = run(
        "map3d", *files, "--poses", poses, "--tsdf", "--resolution", "0.1", "--out", tmp_path / "a.ply", "--json"
    )
    assert json.loads(surface.out)["scans"] == 2
    for arguments, sentence in (
        ((files[0], "--poses", poses), "The number of poses in poses.tum, 2, is not that of the clouds, 1;"),
        ((*files, "--poses", poses, "--sensor", "0,0,0"), "--sensor is the place of one cloud's sensor"),
        ((*files, "--poses", tmp_path / "none.tum"), "There is no file 'none.tum'"),
        ((*files, "--poses", files[0]), "Line 1"),
        ((graph, files[0], "--poses", poses), "contains the poses of its scans"),
        ((graph, "--poses", poses), "contains the poses of its scans"),
    ):
        status, _, err = run("map3d", *arguments, "--out", ours)
        assert status == 2, arguments
        assert sentence in err, (arguments, err)


def test_poses_place_the_clouds_of_a_recording_by_their_times(tmp_path: Path) -> None:
    path = written(tmp_path, recording_of_room(), "mcap")
    known = list(open_posed_clouds(path))
    tum = tmp_path / "poses.tum"
    rows = [(one.cloud.stamp_ns, one.pose) for one in known]
    tum.write_text(
        "".join(
            f"{stamp // 10**9}.{stamp % 10**9:09d} {' '.join(f'{v:.12g}' for v in pose[:3, 3])} "
            f"{' '.join(f'{v:.12g}' for v in Rotation.from_matrix(pose[:3, :3]).as_quat())}\n"
            for stamp, pose in rows[1:]
        )
    )
    placed = list(open_posed_clouds(path, given=GivenPoses.read(tum).at))
    assert len(placed) == len(known) - 1  # the first has no pose
    for one, other in zip(placed, known[1:], strict=True):
        np.testing.assert_allclose(one.pose, other.pose, atol=1e-9)
