"""Pose graphs in g2o's text format, as used by GTSAM, Ceres' examples and most graph optimisers.

Source: g2o's documentation of its file format: ``VERTEX_SE2 id x y theta``, ``FIX id`` and ``EDGE_SE2 i j dx dy dtheta
I11 I12 I13 I22 I23 I33``, metres, radians, the upper triangle of the information matrix; ``#`` starts a comment.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.se2 import wrap_angle
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines
from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph

VERTEX, EDGE, FIX = "VERTEX_SE2", "EDGE_SE2", "FIX"
VALUES = {VERTEX: 4, EDGE: 11}
COLUMNS = {VERTEX: "id x y theta", EDGE: "i j dx dy dtheta I11 I12 I13 I22 I23 I33"}
MOST_ID = 2**53


def read_g2o(path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> PoseGraph:
    """Return the graph in a g2o file, plain or compressed, with nodes in the order of their ids.

    Edges between consecutive nodes are odometry, others loops. Residuals are 0 and weights 1 until the graph is
    optimised. Raises :class:`ReadError`, naming the line, for an unknown line or a wrong number of values, an invalid
    number, a repeated vertex, an edge with missing or identical vertices or whose information is not positive definite,
    and for a file without vertices; :class:`LimitError`.
    """
    lines = TextLines(Path(path), limits)
    vertices: dict[int, tuple[float, ...]] = {}
    edges: list[tuple[int, int, int, list[float]]] = []
    for number, text in lines:
        tokens = text.decode("latin-1").split()
        if not tokens or tokens[0].startswith("#") or tokens[0] == FIX:
            continue
        kind = tokens[0]
        if kind not in VALUES:
            raise ReadError(
                "graph.kind", f"Line {number} begins with {kind!r:.40}: only {VERTEX}, {EDGE} and {FIX} are planar."
            )
        if len(tokens) != VALUES[kind] + 1:
            raise ReadError(
                "graph.columns",
                f"Line {number} has {len(tokens) - 1} values, but {kind} has {VALUES[kind]}: {COLUMNS[kind]}.",
            )
        if kind == VERTEX:
            vertex = _id(tokens[1], number)
            if vertex in vertices:
                raise ReadError("graph.twice", f"Line {number}: vertex {vertex} is defined twice.")
            vertices[vertex] = tuple(fields.pose(tokens[2:], number, "g2o", "the", limits))
        else:
            motion = fields.pose(tokens[3:6], number, "g2o", "the relative", limits)
            values = [*motion, *fields.numbers(tokens[6:], number, "g2o")]
            edges.append((number, _id(tokens[1], number), _id(tokens[2], number), values))
    if lines.broken is not None:
        raise ReadError("graph.truncated", f"{lines.broken}, after line {lines.number}.")
    if not vertices:
        raise ReadError("graph.empty", f"The file holds no vertices, lines of {VERTEX} {COLUMNS[VERTEX]}.")
    return _graph(vertices, edges)


def g2o_lines(graph: PoseGraph) -> Iterator[str]:
    """Return the lines of a g2o file of the graph: vertices by scan number, the first one fixed, then the edges."""
    for node, (x, y, theta) in zip(graph.nodes.tolist(), graph.poses.tolist(), strict=True):
        yield f"{VERTEX} {node} {x!r} {y!r} {theta!r}\n"
    if len(graph.nodes):
        yield f"{FIX} {int(graph.nodes[0])}\n"
    ends = graph.nodes[graph.i].tolist(), graph.nodes[graph.j].tolist()
    upper = graph.information[:, *np.triu_indices(3)].tolist()
    for i, j, motion, row in zip(*ends, graph.relative.tolist(), upper, strict=True):
        yield " ".join([EDGE, str(i), str(j), *(repr(value) for value in (*motion, *row))]) + "\n"


def _id(token: str, line: int) -> int:
    if not (token.isascii() and token.isdigit() and int(token[:20]) < MOST_ID):
        raise ReadError("graph.id", f"Line {line}: {token!r:.40} is not the number of a vertex.")
    return int(token)


def _graph(vertices: dict[int, tuple[float, ...]], edges: list[tuple[int, int, int, list[float]]]) -> PoseGraph:
    nodes = np.array(sorted(vertices), dtype=np.int64)
    poses = np.array([vertices[node] for node in nodes.tolist()])
    poses[:, 2] = wrap_angle(poses[:, 2])
    rows = {node: row for row, node in enumerate(nodes.tolist())}
    information = np.zeros((len(edges), 3, 3))
    for k, (line, i, j, values) in enumerate(edges):
        for end in (i, j):
            if end not in rows:
                raise ReadError(
                    "graph.ends", f"Line {line}: the edge ends at vertex {end}, which the file does not define."
                )
        if i == j:
            raise ReadError("graph.ends", f"Line {line}: the edge joins vertex {i} to itself.")
        information[k][np.triu_indices(3)] = values[3:]
        information[k] += np.triu(information[k], 1).T
        if not (np.isfinite(information[k]).all() and np.linalg.eigvalsh(information[k])[0] > 0.0):
            raise ReadError("graph.information", f"Line {line}: the information matrix is not positive definite.")
    ends = np.array([(rows[i], rows[j]) for _, i, j, _ in edges], dtype=np.int64).reshape(-1, 2)
    relative = np.array([values[:3] for *_, values in edges]).reshape(-1, 3)
    relative[:, 2] = wrap_angle(relative[:, 2])
    return PoseGraph(
        nodes,
        poses,
        ends[:, 0],
        ends[:, 1],
        relative,
        information,
        np.where(np.abs(ends[:, 1] - ends[:, 0]) == 1, ODOMETRY, LOOP),
        np.zeros(len(edges), dtype=np.bool_),
        np.zeros(len(edges)),
        np.ones(len(edges)),
    )
