"""The tree of frames by the rules of tf2, each beside what tf2's own sources say of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs.recording.runs import Track, offsets_of_runs, steps_back
from mapper.io.logs.recording.tf_topics import TfTopics
from mapper.io.logs.recording.timeline import Moments
from mapper.io.logs.recording.transforms import FrameTree, why_ignored
from mapper.io.logs.ros.message_fields import Pose7
from mapper.io.logs.ros.ros_messages import StampedPose

S = 1_000_000_000
Row = tuple[float, str, str, float, float, float, bool]  #: seconds, parent, child, x, y, yaw, whether it is static


def pose(x: float, y: float = 0.0, yaw: float = 0.0) -> Pose7:
    return (x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def tree_of(*rows: Row) -> FrameTree:
    tree = FrameTree(DEFAULT_LIMITS)
    for number, (at, parent, child, x, y, yaw, is_static) in enumerate(rows):
        one = StampedPose(round(at * S), parent, child, pose(x, y, yaw))
        assert not tree.add(one, is_static=is_static, position=10 * number)
    return tree


def when(*seconds: float, positions: list[int] | None = None) -> Moments:
    return Moments(
        np.array([round(one * S) for one in seconds]),
        None if positions is None else np.array(positions, dtype=np.int64),
    )


def planar(x: float, y: float, yaw: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


ROBOT: tuple[Row, ...] = (
    (0.0, "base", "laser", 0.3, 0.1, 0.5, True),
    (0.0, "base", "camera", -0.2, 0.0, 3.0, True),
    (0.0, "odom", "base", 1.0, 0.0, 0.0, False),
    (2.0, "odom", "base", 3.0, 0.0, 0.0, False),
    (0.0, "beacon", "tag", 1.0, 1.0, 1.0, True),
)


@pytest.mark.parametrize(
    ("source", "target", "expected"),
    [
        ("laser", "base", planar(0.3, 0.1, 0.5)),
        ("base", "laser", np.linalg.inv(planar(0.3, 0.1, 0.5))),
        ("laser", "camera", np.linalg.inv(planar(-0.2, 0.0, 3.0)) @ planar(0.3, 0.1, 0.5)),
        ("laser", "odom", planar(2.0, 0.0, 0.0) @ planar(0.3, 0.1, 0.5)),
        ("odom", "laser", np.linalg.inv(planar(2.0, 0.0, 0.0) @ planar(0.3, 0.1, 0.5))),
        ("laser", "laser", np.eye(3)),
    ],
)
def test_a_look_up_goes_over_the_common_ancestor(source: str, target: str, expected: np.ndarray) -> None:
    """BufferCore::walkToTopParent."""
    found = tree_of(*ROBOT).relative(source, target, when(1.0))
    assert found is not None
    np.testing.assert_allclose(planar(*found.planar[0]), expected, atol=1e-12)


def test_trees_that_are_not_connected_have_no_transform() -> None:
    """BufferCore::walkToTopParent: TF2_CONNECTIVITY_ERROR."""
    tree = tree_of(*ROBOT)
    assert tree.relative("laser", "tag", when(1.0)) is None
    assert tree.relative("laser", "nothing", when(1.0)) is None
    assert not tree.covers_relative("laser", "tag", when(1.0)).any()


def test_between_two_parents_the_earlier_one_holds() -> None:
    """TimeCache::getData: no interpolation where the parents of the two differ."""
    rows: list[Row] = [(0.0, "base", "left", 0.0, 1.0, 0.0, True), (0.0, "base", "right", 0.0, -1.0, 0.0, True)]
    rows += [(t, "left" if t < 3 else "right", "tool", 0.5 + t, 0.0, 0.0, False) for t in (0.0, 1.0, 2.0, 3.0, 4.0)]
    found = tree_of(*rows).relative("tool", "base", when(0.5, 2.5, 3.5))
    assert found is not None
    np.testing.assert_allclose(found.positions[:, 1], [1.0, 1.0, -1.0])
    np.testing.assert_allclose(found.positions[[0, 2], 0], [1.0, 4.0])
    assert found.positions[1, 0] == pytest.approx(2.5)


def test_late_transforms_are_put_in_their_order() -> None:
    """TimeCache::insertData."""
    rows: list[Row] = [(t, "odom", "base", t, 0.0, 0.0, False) for t in (0.0, 1.0, 3.0, 2.0, 4.0)]
    found = tree_of(*rows).relative("base", "odom", when(1.5, 2.5))
    assert found is not None
    np.testing.assert_allclose(found.positions[:, 0], [1.5, 2.5])


def test_a_static_transform_holds_until_it_is_replaced() -> None:
    """StaticCache has one transform; which parent it has may change with it. The order is that of the messages."""
    rows: list[Row] = [
        (9.0, "base", "laser", 1.0, 0.0, 0.0, True),
        (9.0, "base", "mast", 0.0, 5.0, 0.0, True),
        (1.0, "mast", "laser", 2.0, 0.0, 0.0, True),
        (1.0, "mast", "laser", 2.0, 0.0, 0.0, True),
    ]
    tree = tree_of(*rows)
    found = tree.relative("laser", "base", when(5.0, 5.0, 5.0, positions=[-1, 15, 25]))
    assert found is not None
    np.testing.assert_allclose(found.positions[:, :2], [[1.0, 0.0], [1.0, 0.0], [2.0, 5.0]])
    latest = tree.relative("laser", "base", when(5.0))
    assert latest is not None
    np.testing.assert_allclose(latest.positions[:, :2], [[2.0, 5.0]])
    assert tree.replaced_statics(("laser", "mast")) == ["laser"]
    assert not tree.is_fixed("laser", "base")
    assert tree.is_fixed("mast", "base")


@pytest.mark.parametrize(
    ("parent", "child", "stated", "why"),
    [
        ("a", "b", pose(1.0), ""),
        ("a", "b", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.004), ""),
        ("a", "b", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.006), "its quaternion has the length 1.01, not 1"),
        ("a", "b", (1.0, 0.0, 0.0, 0.0, 0.0, 0.7, 0.7), "its quaternion has the length 0.99, not 1"),
        ("a", "b", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), "its quaternion is 0, 0, 0, 0, which is no rotation"),
        ("a", "b", (1.0, 0.0, 0.0, 0.0, math.nan, 0.0, 1.0), "its quaternion is not finite"),
        ("a", "b", pose(math.nan), "its position is not finite"),
        ("a", "b", pose(math.inf), "its position is not finite"),
        ("a", "b", pose(5.3e6), ""),
        ("a", "b", pose(1e9), "its position is beyond 1e+08 m"),
        ("a", "a", pose(1.0), "it is of a frame in itself"),
        ("", "b", pose(1.0), "it does not name its parent frame"),
        ("a", "", pose(1.0), "it does not name its child frame"),
    ],
)
def test_transforms_that_tf2_ignores(parent: str, child: str, stated: Pose7, why: str) -> None:
    """BufferCore::setTransformImpl; infinite positions, which it lets pass, and those of no place are ignored too."""
    assert why_ignored(parent, child, stated) == why
    assert bool(FrameTree(DEFAULT_LIMITS).add(StampedPose(S, parent, child, stated))) == bool(why)


def test_a_slash_before_a_frame_is_no_part_of_it() -> None:
    """BufferCore::setTransformImpl strips it of both."""
    assert "in itself" in FrameTree(DEFAULT_LIMITS).add(StampedPose(S, "/a", "a", pose(1.0)))
    tree = tree_of((0.0, "/a", "/b", 1.0, 0.0, 0.0, True))
    assert tree.relative("b", "a", when(0.0)) is not None


@pytest.mark.parametrize(
    ("stamps", "expected"),
    [
        ([0, 1, 2, 3, 4], []),
        ([0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1], [5, 10]),
        ([10, 11, 12, 8, 13, 14], []),  # one that is late
        ([10, 11, 12, 8, 13, 9, 14, 10, 15], []),  # a publisher that is late each time
        ([10, 11, 12, 11.6, 13], []),  # less than half a second
        ([10, 11, 12, 3], [3]),
        ([10, 11, 12, 10.5, 11.5, 12.5, 13.5], []),  # it has caught up after two
    ],
)
def test_where_stamps_step_back_and_stay(stamps: list[float], expected: list[int]) -> None:
    assert steps_back(np.array([round(one * S) for one in stamps])) == expected


def test_runs_are_counted_on_where_most_topics_begin_again() -> None:
    first = np.arange(0, 10 * S, S // 2)
    twice, once = np.concatenate([first, first]), np.arange(0, 20 * S, S // 2)
    positions = np.arange(len(twice)) * 3
    tracks = [Track("/scan", twice, positions), Track("/tf", twice, positions + 1), Track("/imu", once, positions + 2)]
    offsets = offsets_of_runs(tracks)
    assert offsets is not None
    for track, own in zip(tracks, offsets, strict=True):
        assert (np.diff(track.stamps_ns + own) > 0).all()
        assert np.flatnonzero(np.diff(own)).tolist() == [19]
    assert offsets_of_runs([tracks[0], tracks[2]]) is None
    assert offsets_of_runs([tracks[0], tracks[2], Track("/odom", once, positions + 1)]) is None


@pytest.mark.parametrize(
    ("topics", "sensor", "moving", "static"),
    [
        ("/tf /tf_static", "/scan", "/tf", "/tf_static"),
        ("/tf /tf_static", "/front/scan", "/tf", "/tf_static"),
        ("/a/tf /a/tf_static /b/tf /b/tf_static", "/b/scan", "/b/tf", "/b/tf_static"),
        ("/a/tf /a/tf_static /tf /tf_static", "/a/front/scan", "/a/tf", "/a/tf_static"),
        ("/a/tf /a/tf_static /tf /tf_static", "/scan", "/tf", "/tf_static"),
        ("/a/tf /tf_static", "/a/scan", "/a/tf", "/tf_static"),
        ("/tf /a/tf_static", "/a/scan", "/tf", "/a/tf_static"),
        ("/tf /tf_gt /tf_static", "/scan", "/tf", "/tf_static"),
        ("/a/tf /a/tf_static", "/scan", "/a/tf", "/a/tf_static"),
        ("tf tf_static", "scan", "tf", "tf_static"),
    ],
)
def test_the_transforms_of_a_sensor_are_those_of_its_namespace(
    topics: str, sensor: str, moving: str, static: str
) -> None:
    known = TfTopics(DEFAULT_LIMITS)
    for topic in topics.split():
        frames = ("base", "laser") if topic.endswith("static") else ("odom", "base")
        known.add(topic, StampedPose(S, *frames, pose(1.0)), 0)
    choice = known.choice(sensor, "laser")
    assert (choice.moving, choice.static) == (moving, static)
    assert ("/tf_gt" in choice.others) == ("/tf_gt" in topics)
