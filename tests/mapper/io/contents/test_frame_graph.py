"""Faults of a graph of transforms."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.io.contents.frame_graph import chain_of, faults, parents_of
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
            "No transform joins 'base', the root above the sensor's frame 'laser', with 'map', the root above 'map'.",
        ),
        ([("map", "odom")], ["laser"], "No transform names the sensor's frame 'laser'."),
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
