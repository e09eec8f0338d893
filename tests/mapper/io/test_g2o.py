"""Pose graphs in g2o's format: what is written is read again, and files with errors are refused by line."""

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ReadError
from mapper.io.graphs import g2o_lines, read_g2o
from mapper.sensors.pose_graph import LOOP, ODOMETRY

#: As g2o's own tools write it.
SQUARE = """\
VERTEX_SE2 0 0 0 0
FIX 0
VERTEX_SE2 1 1.05 0.02 1.57
# a remark
VERTEX_SE2 2 1 1 3.14159
VERTEX_SE2 3 0 1 -1.57
EDGE_SE2 0 1 1 0 1.570796 100 0 0 100 0 400
EDGE_SE2 1 2 1 0 1.570796 100 1 2 100 3 400
EDGE_SE2 2 3 1 0 1.570796 100 0 0 100 0 400
EDGE_SE2 3 0 1 0 1.570796 100 0 0 100 0 400
"""


def test_reads_vertices_edges_and_the_upper_triangle(tmp_path: Path) -> None:
    path = tmp_path / "square.g2o"
    path.write_text(SQUARE)
    graph = read_g2o(path)
    assert graph.nodes.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(graph.poses[1], [1.05, 0.02, 1.57])
    assert graph.kind.tolist() == [ODOMETRY, ODOMETRY, ODOMETRY, LOOP]
    np.testing.assert_array_equal(graph.information[1], [[100, 1, 2], [1, 100, 3], [2, 3, 400]])


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    path, again = tmp_path / "square.g2o", tmp_path / "again.g2o"
    path.write_text(SQUARE)
    graph = read_g2o(path)
    again.write_text("".join(g2o_lines(graph)))
    second = read_g2o(again)
    for name in ("nodes", "poses", "i", "j", "relative", "information", "kind"):
        np.testing.assert_array_equal(getattr(second, name), getattr(graph, name))


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("", "graph.empty", "no vertices"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "graph.kind", "Line 1 begins with 'VERTEX_SE3:QUAT'"),
        ("VERTEX_SE2 0 0 0\n", "graph.columns", "Line 1 has 3 values, but VERTEX_SE2 has 4"),
        ("VERTEX_SE2 0 0 0 nan\n", "log.pose", "Line 1: the pose"),
        ("VERTEX_SE2 0 -inf 0 0\n", "log.pose", "Line 1: the pose"),
        (SQUARE + "EDGE_SE2 0 2 1 nan 0 1 0 0 1 0 1\n", "log.pose", "Line 11: the relative pose"),
        (SQUARE + "EDGE_SE2 0 2 1 0 inf 1 0 0 1 0 1\n", "log.pose", "Line 11: the relative pose"),
        (SQUARE + "EDGE_SE2 0 2 1 0 0 nan 0 0 1 0 1\n", "graph.information", "Line 11: the information matrix"),
        ("VERTEX_SE2 a 0 0 0\n", "graph.id", "Line 1: 'a' is not the number of a vertex"),
        ("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 1 0 0\n", "graph.twice", "Line 2: vertex 0 is defined twice"),
        (SQUARE + "EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1\n", "graph.ends", "Line 11: the edge ends at vertex 9"),
        (SQUARE + "EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n", "graph.ends", "Line 11: the edge joins vertex 1 to itself"),
        (SQUARE + "EDGE_SE2 0 2 1 0 0 1 0 0 -1 0 1\n", "graph.information", "Line 11: the information matrix"),
        (SQUARE + "EDGE_SE2 0 2 1 0 0 1 0 0 inf 0 1\n", "graph.information", "Line 11: the information matrix"),
        (SQUARE + "EDGE_SE2 0 2 1 0 x 1 0 0 1 0 1\n", "log.not_a_number", "Line 11: 'x'"),
    ],
)
def test_files_with_errors(tmp_path: Path, text: str, code: str, said: str) -> None:
    path = tmp_path / "bad.g2o"
    path.write_text(text)
    with pytest.raises(ReadError) as caught:
        read_g2o(path)
    assert caught.value.code == code
    assert said in caught.value.message
