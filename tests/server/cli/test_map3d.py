"""``gridbloom map3d``: octrees that OctoMap reads, and maps from above."""

from __future__ import annotations

import json
from pathlib import Path

import pyoctomap

from mapper.io.maps import load_map
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
        ((graph, "--out", tree, "--map", tmp_path / "m", "--band", "7,8"), "Nothing is known between 7 and 8 m"),
    ):
        status, _, err = run("map3d", *arguments)
        assert status == 2
        assert said in err
        assert err.count("\n") == 1
