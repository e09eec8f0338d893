"""What a click in the 3D view of a log means."""

from __future__ import annotations

import math

import numpy as np
import pytest

from server.parts.slam.solved_graph import LOOP_Z, SolvedGraph
from server.sessions.parts import ShownLoops
from server.sources.scene_picks import ScenePick, picked_by
from server.stream.messages import PickedMessage
from tests.server.library.processing.slam_stand_ins import chain

Vector = tuple[float, float, float]
EYE: Vector = (0.0, -6.0, 6.0)
POSES = np.array([(0.0, 0.0, 0.1), (1.0, 0.0, 0.2), (2.0, 0.0, 0.3)])
LOOPS = ShownLoops(np.array([4, 7]), np.array([[[5.0, 0.0, 0.0], [5.0, 8.0, 0.0]], [[0.0, 3.0, 0.0], [3.0, 3.0, 0.0]]]))


def click(at: Vector, met: Vector | None = None, loops: ShownLoops | None = LOOPS) -> PickedMessage | None:
    """A click from :data:`EYE` at a place; ``met`` is where a column is in the way."""
    return picked_by(ScenePick(EYE, tuple(np.subtract(at, EYE).tolist()), met), POSES, loops)


def beside(at: Vector, degrees: float) -> Vector:
    """The place that is seen from :data:`EYE` so far to the right of another."""
    return (at[0] + math.tan(math.radians(degrees)) * math.dist(EYE, at), at[1], at[2])


@pytest.mark.parametrize(
    ("degrees", "what"), [(0.0, "loop"), (0.8, "loop"), (-0.8, "loop"), (2.0, "cell"), (-2.0, "cell")]
)
def test_a_loop_is_meant_within_a_degree_of_its_line(degrees: float, what: str) -> None:
    # The eye and the loop are in the plane x = 5 m, which is crossed at right angles.
    eye: Vector = (5.0, -6.0, 6.0)
    at = (5.0 + math.tan(math.radians(degrees)) * math.dist(eye, (5.0, 4.0, 0.0)), 4.0, 0.0)
    along = tuple(np.subtract(at, eye).tolist())
    picked = picked_by(ScenePick(eye, along, None), POSES, LOOPS)
    assert picked is not None
    assert picked.what == what
    assert picked.edge == (4 if what == "loop" else None)


def test_a_loop_ends_where_its_nodes_are() -> None:
    inside, outside = click((2.9, 3.0, 0.0)), click(beside((3.0, 3.0, 0.0), 1.5))
    assert inside is not None
    assert outside is not None
    assert (inside.edge, inside.x, inside.y) == (7, 1.5, 3.0)
    assert outside.what == "cell"


def test_a_pose_is_named_by_the_scans_up_to_it() -> None:
    assert click(beside((1.0, 0.0, 0.0), 0.5)) == PickedMessage("pose", 1.0, 0.0, yaw=0.2, index=2, edge=None)


def test_what_a_column_hides_is_not_meant() -> None:
    assert click((1.0, 3.0, 0.0), met=(0.5, -1.5, 3.0)) == PickedMessage("cell", 0.5, -1.5, None, None, None)
    # Its own foot is no hindrance.
    at_its_foot = click((1.0, 3.0, 0.0), met=(0.99, 2.9, 0.07))
    assert at_its_foot is not None
    assert at_its_foot.edge == 7


def test_without_loops_and_away_from_the_path_the_floor_is_meant() -> None:
    assert click((1.0, 3.0, 0.0), loops=None) == PickedMessage("cell", 1.0, 3.0, None, None, None)


@pytest.mark.parametrize("along", [(0.0, 1.0, 1.0), (0.0, 1.0, 0.0)])
def test_the_sky_means_nothing(along: Vector) -> None:
    assert picked_by(ScenePick(EYE, along, None), POSES, LOOPS) is None


def test_the_loops_in_3d_are_those_of_the_graph() -> None:
    graph, tried = chain(6)
    loops, drawing = SolvedGraph.of("SLAM", graph.poses, graph, tried).in_3d()
    assert loops.edges.tolist() == [5]
    np.testing.assert_allclose(loops.ends[0], [[0.0, graph.poses[0, 1], LOOP_Z], [5.0, graph.poses[0, 1], LOOP_Z]])
    np.testing.assert_allclose(drawing.points, loops.ends)
