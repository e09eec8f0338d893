"""Graph of transforms as in tf2: connected frames, and missing links to a fixed frame.

Source: the tf2 design (a frame has one parent; a lookup follows parents to the common ancestor); REP 105.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from mapper.io.contents.model import FrameEdge
from mapper.io.logs.recording.tf_topics import STATIC, is_static, namespaces

TF_STATIC = "tf_static"
MAX_NAMED = 20  #: frames of a loop that are listed


def trees_of(edges: Sequence[FrameEdge], sensor: str = "") -> dict[str, list[FrameEdge]]:
    """Return the edges of each tree, by the topic of non-static transforms.

    Robots may have the same frames, each on its own topics (:mod:`mapper.io.logs.recording.tf_topics`). The static
    transforms of a tree are those of the same namespace, or of the nearest one enclosing it or the topic ``sensor``.
    """
    statics = list(dict.fromkeys(edge.topic for edge in edges if is_static(edge.topic)))
    trees = {}
    for topic in dict.fromkeys(edge.topic for edge in edges if not is_static(edge.topic)):
        around = [f"{space}/{TF_STATIC}" for topic_ in (topic, sensor) for space in namespaces(topic_)]
        topics = [topic + STATIC, *around, *(statics if len(statics) == 1 else [])]
        static = next((topic_ for topic_ in topics if topic_ in statics), None)
        trees[topic] = [edge for edge in edges if edge.topic in (topic, static)]
    return trees or {topic: [edge for edge in edges if edge.topic == topic] for topic in statics}


def tree_for(trees: Mapping[str, Sequence[FrameEdge]], sensor: str, frame: str) -> str:
    """Return the topic of the tree with the ``frame`` of a ``sensor``: the nearest to its topic, "" for none."""
    near = [topic for space in namespaces(sensor) for topic in trees if topic == f"{space}/tf"]
    ranked = [*near, *sorted((tree for tree in trees if tree not in near), key=lambda topic_: -_count(trees[topic_]))]
    knows = [topic_ for topic_ in ranked if any(frame in (edge.parent, edge.child) for edge in trees[topic_])]
    return next(iter([*knows, *ranked]), "")


def _count(edges: Iterable[FrameEdge]) -> int:
    return sum(len(edge.stamps_ns) for edge in edges)


def parents_of(edges: Iterable[FrameEdge]) -> dict[str, str]:
    """Return the parent of each frame; if several are stated, the most frequent one.

    tf2 uses the newest instead, so that such a frame jumps, which :func:`faults` reports.
    """
    parent_edges: dict[str, FrameEdge] = {}
    for edge in edges:
        if edge.child not in parent_edges or len(edge.stamps_ns) > len(parent_edges[edge.child].stamps_ns):
            parent_edges[edge.child] = edge
    return {child: edge.parent for child, edge in parent_edges.items()}


def chain_of(parents: dict[str, str], frame: str) -> list[str]:
    """Return ``frame``, its parent and so on to the root, or to the first repeated frame."""
    chain: dict[str, None] = {}  # used as an ordered set
    above: str | None = frame
    while above is not None and above not in chain:
        chain[above] = None
        above = parents.get(above)
    return [*chain]


def faults(edges: Sequence[FrameEdge], sensors: Iterable[str], fixed: str) -> list[str]:
    """Return the faults of the graph, one sentence each: missing links, loops, several parents.

    ``sensors`` are the frames that must be connected to the frame ``fixed``.
    """
    sentences = []
    stated: dict[str, set[str]] = {}
    for edge in edges:
        stated.setdefault(edge.child, set()).add(edge.parent)
    for child, several in sorted(stated.items()):
        if len(several) > 1:
            names = ", ".join(repr(name) for name in sorted(several))
            sentences.append(f"The frame {child!r} has {len(several)} parents, {names}: tf allows one.")
    parents = parents_of(edges)
    looping = frames_in_loops(parents)
    if looping:
        names = ", ".join(map(repr, looping[:MAX_NAMED]))
        more = f" and {len(looping) - MAX_NAMED} more" if len(looping) > MAX_NAMED else ""
        sentences.append(f"The transforms go round in a loop: {names}{more}.")
    fixed_chain = chain_of(parents, fixed)
    for sensor in sorted(set(sensors)):
        chain = chain_of(parents, sensor)
        if not set(chain) & set(fixed_chain):
            if sensor not in stated and all(edge.parent != sensor for edge in edges):
                sentences.append(f"No transform names the sensor’s frame {sensor!r}.")
            else:
                sentences.append(
                    f"No transform joins {chain[-1]!r}, the root above the sensor’s frame {sensor!r}, with "
                    f"{fixed_chain[-1]!r}, the root above {fixed!r}."
                )
    return sentences


def frames_in_loops(parents: dict[str, str]) -> list[str]:
    """Return the frames that are their own ancestors, in order, in linear time."""
    walk_of: dict[str, int] = {}
    frames = []
    for walk, start in enumerate(parents):
        path = []
        frame: str | None = start
        while frame is not None and frame not in walk_of:
            walk_of[frame] = walk
            path.append(frame)
            frame = parents.get(frame)
        if frame is not None and walk_of[frame] == walk:
            frames += path[path.index(frame) :]
    return sorted(frames)
