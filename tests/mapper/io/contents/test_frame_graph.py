"""Faults of a graph of transforms."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.io.contents.frame_graph import (
    chain_of,
    faults,
    frames_in_loops,
    parents_of,
    tree_for,
    trees_of,
)
from mapper.io.contents.model import FrameEdge


def edges(*pairs: tuple[str, str], times: int = 3) -> list[FrameEdge]:
    return [FrameEdge(parent, child, False, np.arange(1, times + 1)) for parent, child in pairs]


def test_a_whole_tree_has_no_faults() -> None:
    whole = edges(("map", "odom"), ("odom", "base"), ("base", "laser"), ("base", "camera"))
    assert chain_of(parents_of(whole), "laser") == ["laser", "base", "odom", "map"]
    assert faults(whole, ["laser", "camera"], "map") == []


@pytest.mark.parametrize(
    ("pairs", "sensors", "said"),
    [
        (
            [("map", "odom"), ("base", "laser")],
            ["laser"],
            "No transform joins 'base', the root above the sensor’s frame 'laser', with 'map', the root above 'map'.",
        ),
        ([("map", "odom")], ["laser"], "No transform names the sensor’s frame 'laser'."),
        (
            [("odom", "base"), ("vision", "base"), ("odom", "map"), ("base", "laser")],
            ["laser"],
            "The frame 'base' has 2 parents, 'odom', 'vision': tf allows one.",
        ),
        (
            [("a", "b"), ("b", "c"), ("c", "a"), ("c", "laser"), ("laser", "map")],
            ["laser"],
            "The transforms go round in a loop: 'a', 'b', 'c'.",
        ),
    ],
)
def test_missing_and_invalid_frames_are_reported(pairs: list[tuple[str, str]], sensors: list[str], said: str) -> None:
    assert faults(edges(*pairs), sensors, "map") == [said]


def test_of_several_parents_the_one_that_is_stated_most_often_counts() -> None:
    both = [*edges(("odom", "base"), times=2), *edges(("vision", "base"), times=5)]
    assert parents_of(both) == {"base": "vision"}


@pytest.mark.parametrize("seed", range(20))
def test_the_frames_in_loops_are_those_above_themselves(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parents = {str(child): str(parent) for child, parent in enumerate(rng.integers(0, 14, rng.integers(1, 13)))}

    def is_above_itself(frame: str) -> bool:
        above: str | None = frame
        for _ in parents:
            above = None if above is None else parents.get(above)
            if above == frame:
                return True
        return False

    assert frames_in_loops(parents) == sorted(filter(is_above_itself, parents))


class _Counted(str):
    """A name that counts its comparisons."""

    compared = 0
    __slots__ = ()
    __hash__ = str.__hash__

    def __eq__(self, other: object) -> bool:
        _Counted.compared += 1
        return str.__eq__(self, other)


def test_the_work_on_a_loop_of_thousands_is_linear(monkeypatch: pytest.MonkeyPatch) -> None:
    """A recording of a few hundred kB can state one; one of 1,000 held up the event loop for 25 s."""
    size = 2000
    monkeypatch.setattr(_Counted, "compared", 0)
    names = [_Counted(f"f{number}") for number in range(size)]
    loop = edges(*zip(names, [*names[1:], names[0]], strict=True), times=1)
    said = faults(loop, ["laser"], names[0])
    assert said[0].endswith(f"and {size - 20} more.")
    assert len(said[0]) < 300
    assert _Counted.compared < 50 * size


def test_the_trees_of_robots_with_the_same_frames_are_kept_apart() -> None:
    stamps = np.arange(1, 4)

    def edge(topic: str, parent: str, child: str) -> FrameEdge:
        return FrameEdge(parent, child, topic.endswith("_static"), stamps, topic)

    robots = [
        edge(f"{space}{name}", *pair)
        for space, laser in (("/a", "laser"), ("/b", "lidar"))
        for name, pair in (("/tf", ("odom", "base")), ("/tf_static", ("base", laser)))
    ]
    both = [*robots, edge("/tf", "map", "/a/odom")]
    trees = trees_of(both, "/b/scan")
    assert list(trees) == ["/a/tf", "/b/tf", "/tf"]
    assert [(one.topic, one.child) for one in trees["/b/tf"]] == [("/b/tf", "base"), ("/b/tf_static", "lidar")]
    assert tree_for(trees, "/b/front/scan", "lidar") == "/b/tf"
    assert faults(trees["/b/tf"], ["lidar"], "odom") == []
    assert tree_for(trees, "/scan", "laser") == "/a/tf", "where the nearest does not know the frame"
    # One robot whose static transforms are in its namespace, and whose others are not.
    (only,) = trees_of([edge("/tf", "odom", "base"), edge("/b/tf_static", "base", "lidar")], "/b/scan").values()
    assert len(only) == 2
    assert tree_for({}, "/scan", "laser") == ""
