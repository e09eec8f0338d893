"""Frame tree as in tf: the pose of a frame in another.

The rules are those of tf2 (ros2/geometry2, tf2/src: buffer_core.cpp, cache.cpp, static_cache.cpp), as far as they can
be followed when all messages are known:

- Frames: a leading slash is not part of a name (``BufferCore::setTransform`` strips it).
- Invalid transforms are ignored individually, not with their message: from a frame to itself, without the name of
  either frame, with a number that is not finite, with a quaternion whose squared length deviates from 1 by more than
  0.01 (``QUATERNION_NORMALIZATION_TOLERANCE``).
- A frame has one parent at a time, stored with the transform (``TransformStorage::frame_id_``). Between two transforms
  with the same parent poses are interpolated; where the parent changes, the earlier one holds (``TimeCache::getData``).
  Late transforms are sorted in (``TimeCache::insertData``).
- A static transform holds until it is replaced, also by one with another parent; there is no interpolation between the
  two (``StaticCache``). tf2 uses the last one received; so here a scan uses the last one received before it or, before
  the first of them, the first, because recorders often start late.
- A look-up goes up from both frames to their first common ancestor, so that it works in any direction
  (``BufferCore::walkToTopParent``); frames of unconnected trees have no transform.
- When the clock restarts, non-static transforms are dropped (:mod:`mapper.io.logs.recording.runs`).

There are two differences. If several parents of a frame are stated alternately, tf2 jumps between them with every
message; here each is kept, and the robot's base has a trajectory in each (:meth:`FrameTree.worlds`). And nothing is
extrapolated: :meth:`FrameTree.covers` returns which times are known. Conventions of frames: REP 103, REP 105.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.io.logs.recording.poses3 import Poses3, identity, poses_of, why_no_pose
from mapper.io.logs.recording.timeline import Moments, Timeline
from mapper.io.logs.ros.message_fields import Pose7
from mapper.io.logs.ros.ros_messages import StampedPose
from mapper.sensors.robot_log import TransformEdge

MAX_FRAMES = 5000
MAX_DEPTH = 64  #: frames from a sensor's up to the root
MAX_WORLDS = 8  #: fixed frames in which the robot's trajectory is computed
MAX_CHOICES = 64  #: combinations of parents tried in one look-up
BASES = ("base_link", "base_footprint", "base", "base_frame")
WORLDS = ("map", "odom", "odom_combined", "world", "earth")
_WORLD_WORDS = frozenset(("map", "odom", "odometry", "vision", "world", "earth"))  #: words in names of fixed frames
_WORLD_NAMES = frozenset(
    ("camera_init", "lidar_init", "imu_init", "init", "origin", "local_origin", "local_origin_ned", "utm", "enu", "ned")
)  #: complete names of fixed frames: a gripper's are tool_origin and gripper_init

Path = tuple[str, ...]  #: frames, each the parent or a child of the next


@dataclass(slots=True)
class _Statics:
    """The static transforms of one frame in order of arrival."""

    parents: list[str] = field(default_factory=list)
    values: list[Pose7] = field(default_factory=list)
    positions: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    recorded: list[int] = field(default_factory=list)  #: recording times, 0 if unknown
    again: list[int] = field(default_factory=list)  #: recording time of the last consecutive repetition of each

    @property
    def track(self) -> tuple[Int64Array, Int64Array, Int64Array]:
        """The stamps (n,), the indices of their messages (n,) and their recording times (n,)."""
        return np.array(self.stamps), np.array(self.positions), np.array(self.recorded)

    def put_in_order(self) -> None:
        """Sort them by recording time; see :meth:`at`."""
        ends = zip(self.recorded, self.again, strict=True)
        times = sorted((time, index) for index, both in enumerate(ends) for time in both)
        unique = [times[0], *(after for before, after in pairwise(times) if before[1] != after[1])]
        which = [index for _, index in unique]
        self.positions, self.recorded, self.again = ([time for time, _ in unique] for _ in range(3))
        self.parents = [self.parents[index] for index in which]
        self.values = [self.values[index] for index in which]
        self.stamps = [self.stamps[index] for index in which]

    def at(self, positions: Int64Array | None) -> Int64Array:
        """Return which of them hold at the messages with these indices (n,); without indices, the last (1,).

        After :meth:`put_in_order`, the indices are the recording times of the messages.
        """
        if positions is None or len(self.parents) == 1:
            return np.array([len(self.parents) - 1])
        return np.maximum(np.searchsorted(np.array(self.positions), positions, side="right") - 1, 0)

    def of(self, parent: str) -> Int64Array:
        """Return which of them have this parent."""
        return np.array([index for index, name in enumerate(self.parents) if name == parent], dtype=np.int64)

    @property
    def changes(self) -> bool:
        """Whether one was replaced by a different one."""
        return any(value != self.values[0] for value in self.values) or any(
            parent != self.parents[0] for parent in self.parents
        )


@dataclass(slots=True)
class Stated:
    """The transforms that the messages of one topic stated."""

    moving: dict[str, dict[str, Timeline]] = field(default_factory=dict)  #: child → parent → T_parent_child
    static: dict[str, _Statics] = field(default_factory=dict)  #: by the child
    children: dict[str, dict[str, None]] = field(default_factory=dict)  #: by the parent
    edges: int = 0
    statics: int = 0

    def add(
        self, transform: StampedPose, limits: Limits, *, is_static: bool, position: int, recorded_ns: int = 0
    ) -> str:
        """Add one transform, recorded at ``recorded_ns``; see :meth:`FrameTree.add`."""
        parent, child = transform.frame.lstrip("/"), transform.child.lstrip("/")
        why = why_ignored(parent, child, transform.pose)
        if why:
            return f"the transform of {child!r:.100} in {parent!r:.100}, as in tf2: {why}"
        known = self.children.setdefault(parent, {})
        if child not in known:
            self.edges += 1
            if self.edges > MAX_FRAMES:
                raise LimitError("log.too_many_frames", f"The log’s tf tree has more than {MAX_FRAMES} frames.")
            known[child] = None
        if not is_static:
            parents = self.moving.setdefault(child, {})
            if parent not in parents:
                parents[parent] = Timeline(limits)
            parents[parent].add(transform.stamp_ns, transform.pose, position, recorded_ns)
            return ""
        statics = self.static.setdefault(child, _Statics())
        if statics.parents and (statics.parents[-1], statics.values[-1]) == (parent, transform.pose):
            statics.again[-1] = recorded_ns
            return ""
        if len(statics.parents) >= limits.max_messages:
            raise LimitError("log.too_many_poses", f"The log has more than {limits.max_messages} poses.")
        self.statics += 1
        statics.parents.append(parent)
        statics.values.append(transform.pose)
        statics.positions.append(position)
        statics.stamps.append(transform.stamp_ns)
        statics.recorded.append(recorded_ns)
        statics.again.append(recorded_ns)
        return ""

    def knows(self, frame: str) -> bool:
        """Return whether a transform of or to a frame was stated."""
        return frame in self.children or frame in self.moving or frame in self.static


class FrameTree:
    """The transforms in one buffer of tf, by the rules above: those of one topic of tf and one of static transforms."""

    def __init__(self, limits: Limits, moving: Stated | None = None, static: Stated | None = None) -> None:
        self._limits = limits
        self._of_moving, self._of_static = moving or Stated(), static or Stated()
        self._moving, self._static = self._of_moving.moving, self._of_static.static

    def add(self, transform: StampedPose, *, is_static: bool = False, position: int = 0) -> str:
        """Add one transform, ``is_static`` if published as constant, of the message with index ``position``.

        Return which one is ignored, and why; nothing if it is valid. Raises :class:`LimitError`.
        """
        stated = self._of_static if is_static else self._of_moving
        return stated.add(transform, self._limits, is_static=is_static, position=position)

    def knows(self, frame: str) -> bool:
        """Return whether a transform of or to a frame was stated."""
        return self._of_moving.knows(frame) or self._of_static.knows(frame)

    def named_alike(self, frame: str) -> list[str]:
        """Return a few frames with the same name as ``frame`` after another prefix or none."""
        names = [*self._of_moving.children, *self._of_static.children, *self._moving, *self._static]
        return [name for name in dict.fromkeys(names) if name != frame and _last(name) == _last(frame)][:3]

    def _children_of(self, frame: str) -> tuple[str, ...]:
        moving, static = (tree.children.get(frame, {}) for tree in (self._of_moving, self._of_static))
        return tuple(dict.fromkeys([*moving, *static]))

    @property
    def frames(self) -> int:
        """Number of frames with a parent."""
        return len(self._moving.keys() | self._static.keys())

    def transforms(self) -> tuple[TransformEdge, ...]:
        """Return the stated transforms of each pair of frames, by child and parent."""
        edges = []
        for child in sorted(self._moving.keys() | self._static.keys()):
            moving, statics = self._moving.get(child, {}), self._static.get(child)
            for parent in sorted(moving.keys() | set(() if statics is None else statics.parents)):
                own = np.zeros(0, dtype=np.int64) if statics is None else statics.of(parent)
                moves = len({statics.values[index] for index in own}) > 1 if statics is not None else False
                line = moving.get(parent)
                count = len(own)
                if line is not None:
                    count, moves = count + len(line), moves or line.moves
                edges.append(TransformEdge(parent, child, bool(len(own)), moves, count))
        return tuple(edges)

    # Parents

    def parents(self, frame: str) -> tuple[str, ...]:
        """Return all parents of a frame, first the one used if no time is given.

        That is the one with most transforms, or the last static one if it arrived after the last of these.
        """
        moving = self._moving.get(frame, {})
        order = sorted(moving, key=lambda name: -len(moving[name]))
        statics = self._static.get(frame)
        if statics is None:
            return tuple(order)
        fixed = list(dict.fromkeys(reversed(statics.parents)))
        is_later = statics.positions[-1] > max((line.last_position for line in moving.values()), default=-1)
        return tuple(dict.fromkeys([*fixed, *order] if is_later else [*order, *fixed]))

    def ancestors(self, frame: str) -> list[str]:
        """Return ``frame``, its parent, and so on to the root. Raises :class:`LimitError` like :meth:`_above`."""
        return self._above(frame, {})

    def _above(self, frame: str, chosen: dict[str, str]) -> list[str]:
        """Return ``frame`` and its ancestors, using the ``chosen`` parents of some frames.

        Raises :class:`LimitError` for an implausibly long chain.
        """
        chain = [frame]
        while True:
            parent = chosen.get(chain[-1]) or next(iter(self.parents(chain[-1])), None)
            if parent is None or parent in chain:
                return chain
            if len(chain) >= MAX_DEPTH:
                raise LimitError(
                    "log.too_many_frames", f"In the log’s tf tree a chain has more than {MAX_DEPTH} frames."
                )
            chain.append(parent)

    def loop_above(self, frame: str) -> list[str]:
        """Return the frames of a loop in which ``frame``'s ancestors end, each the child of the next; none without a
        loop.
        """
        chain = self.ancestors(frame)
        parent = next(iter(self.parents(chain[-1])), None)
        return [] if parent is None else [*chain[chain.index(parent) :], parent]

    def several_parents(self, path: Path) -> list[tuple[str, dict[str, int]]]:
        """Return the frames of a path with several parents, and the number of transforms to each of them.

        Parents of static transforms that replace each other are not counted.
        """
        multiple = []
        for frame in path:
            counts = {parent: len(line) for parent, line in self._moving.get(frame, {}).items()}
            statics = self._static.get(frame)
            if counts and statics is not None:
                counts.setdefault(statics.parents[-1], len(statics.of(statics.parents[-1])))
            if len(counts) > 1:
                multiple.append((frame, counts))
        return multiple

    def replaced_statics(self, frames: Path) -> list[str]:
        """Return which of these frames have a static transform that was replaced by another."""
        return [frame for frame in frames if frame in self._static and self._static[frame].changes]

    # Poses

    def relative(self, source: str, target: str, when: Moments) -> Poses3 | None:
        """Return the poses of ``source`` in ``target``, (n,) or one for all; None if they are never connected.

        At times at which they are not connected, the path of other times is used.
        """
        paths = self._paths(source, target, when)
        if not paths:
            return None
        if len(paths) == 1:
            return self.lookup(paths[0][0], when)
        n = len(when)
        out = Poses3(np.zeros((n, 3)), np.zeros((n, 4)))
        for path, where in paths:
            transform = self.lookup(path, when[where])
            out.positions[where], out.rotations[where] = transform.positions, transform.rotations
        return out

    def covers_relative(self, source: str, target: str, when: Moments) -> NDArray[np.bool_]:
        """Return whether all moving transforms between two frames are known at each time (n,)."""
        covered = np.zeros(len(when), dtype=np.bool_)
        for path, where in self._paths(source, target, when):
            covered[where] = self.covers(path, when.stamps_ns[where])
        return covered

    def path(self, source: str, target: str, chosen: dict[str, str] | None = None) -> Path | None:
        """Return the frames from ``source`` via the first common ancestor to ``target``; None without one."""
        up, down = self._above(source, chosen or {}), self._above(target, chosen or {})
        common = next((frame for frame in up if frame in down), None)
        if common is None:
            return None
        return (*up[: up.index(common) + 1], *reversed(down[: down.index(common)]))

    def _paths(self, source: str, target: str, when: Moments) -> list[tuple[Path, NDArray[np.bool_]]]:
        """Return the paths between two frames, with the times (n,) at which each applies."""
        always = np.ones(len(when), dtype=np.bool_)
        usual = self.path(source, target)
        choices = self._choices(source, target, when)
        if not choices:
            usual = usual or self._any_path(source, target)
            return [] if usual is None else [(usual, always)]
        numbers = np.stack([which for _, _, which in choices], axis=1)
        combinations, of = np.unique(numbers, axis=0, return_inverse=True)
        of = np.ravel(of)
        paths: list[tuple[Path, NDArray[np.bool_]]] = []
        rest = always.copy()
        other = usual or self._any_path(source, target)
        for index, combination in enumerate(combinations[:MAX_CHOICES]):
            chosen = {child: parents[number] for (child, parents, _), number in zip(choices, combination, strict=True)}
            path = self.path(source, target, chosen)
            if path is None or path == other:
                continue
            other = other or path
            paths.append((path, of == index))
            rest &= of != index
        if other is not None and rest.any():
            paths.append((other, rest))
        return paths

    def _choices(self, source: str, target: str, when: Moments) -> list[tuple[str, tuple[str, ...], Int64Array]]:
        """Return the frames above two whose parent changes, their parents, and which of them applies at each time
        (n,).
        """
        choices = []
        seen: set[str] = set()
        todo = [source, target]
        while todo and len(seen) < MAX_DEPTH * 4:
            frame = todo.pop()
            if frame in seen:
                continue
            seen.add(frame)
            parents = self.parents(frame)
            todo += parents
            if len(parents) > 1:
                choices.append((frame, parents, self._parent_at(frame, parents, when)))
        return choices

    def _parent_at(self, frame: str, parents: tuple[str, ...], when: Moments) -> Int64Array:
        """Return which of ``parents`` a frame has at each time (n,): that of the last transform before it."""
        moving = self._moving.get(frame, {})
        if not moving:
            statics = self._static[frame]
            held = np.array([parents.index(name) for name in statics.parents])[statics.at(when.positions)]
            return np.broadcast_to(held, (len(when),))
        if len(moving) == 1:
            return np.full(len(when), parents.index(next(iter(moving))))
        known = [(parents.index(parent), line.in_order[0].stamps_ns) for parent, line in moving.items()]
        stamps = np.concatenate([own for _, own in known])
        numbers = np.concatenate([np.full(len(own), number) for number, own in known])
        order = np.argsort(stamps, kind="stable")
        before = np.maximum(np.searchsorted(stamps[order], when.stamps_ns, side="right") - 1, 0)
        return np.asarray(numbers[order][before])

    def _any_path(self, source: str, target: str, *, rigid: bool = False) -> Path | None:
        """Return the shortest path between two frames via any parents ever stated; None without one.

        If ``rigid``, only via transforms that do not move.
        """
        before: dict[str, str | None] = {source: None}
        level = [source]
        for _ in range(MAX_DEPTH):
            following: list[str] = []
            for frame in level:
                for other in (*self.parents(frame), *self._children_of(frame)):
                    if other in before or (rigid and self._moves(frame, other)):
                        continue
                    before[other] = frame
                    following.append(other)
            if target in before or not following:
                break
            level = following
        if target not in before:
            return None
        path = [target]
        while (last := before[path[-1]]) is not None:
            path.append(last)
        return tuple(reversed(path))

    def _line(self, frame: str, other: str) -> tuple[Timeline | None, bool]:
        """Return the moving transform between two frames of a path, and whether ``frame`` is the child in it."""
        if other in self.parents(frame):
            return self._moving.get(frame, {}).get(other), True
        return self._moving.get(other, {}).get(frame), False

    def moving_lines(self, path: Path) -> list[tuple[int, Timeline]]:
        """Return the moving transforms between consecutive frames of a path, each with the frame's index."""
        lines = [(index, self._line(frame, other)[0]) for index, (frame, other) in enumerate(pairwise(path))]
        return [(index, line) for index, line in lines if line is not None and line.moves]

    def _moves(self, frame: str, other: str) -> bool:
        line, _ = self._line(frame, other)
        return line is not None and line.moves

    def lookup(self, path: Path, when: Moments) -> Poses3:
        """Return the poses of a path's first frame in its last, at n times, or one if none of it moves."""
        poses = identity()
        for frame, other in pairwise(path):
            line, is_up = self._line(frame, other)
            step = self._static_at(frame, other, is_up, when) if line is None else line.at(when.stamps_ns)
            poses = (step if is_up else step.inverse) @ poses
        return poses

    def _static_at(self, frame: str, other: str, is_up: bool, when: Moments) -> Poses3:
        child, parent = (frame, other) if is_up else (other, frame)
        statics = self._static[child]
        own = statics.of(parent)
        held = statics.at(when.positions)
        # While another parent applies, the nearest earlier one of this parent, or its first.
        nearest = own[np.maximum(np.searchsorted(own, held, side="right") - 1, 0)]
        return poses_of(np.array(statics.values)[nearest])

    def covers(self, path: Path, stamps_ns: Int64Array) -> NDArray[np.bool_]:
        """Return whether all moving transforms along a path are known at each time (n,)."""
        covered = np.ones(len(stamps_ns), dtype=np.bool_)
        for frame, other in pairwise(path):
            line, _ = self._line(frame, other)
            if line is not None and line.moves:
                covered &= line.covers(stamps_ns)
        return covered

    def stated(self, path: Path) -> tuple[Moments, Int64Array]:
        """Return the distinct times (n,), ascending, at which any moving transform along a path is stated.

        Also returned are the stamps (n,) as stated.
        """
        lines = [line for frame, other in pairwise(path) if (line := self._line(frame, other)[0]) is not None]
        lines = [line for line in lines if line.moves]
        if not lines:
            return Moments(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)), np.zeros(0, dtype=np.int64)
        moments = [line.in_order[0] for line in lines]
        positions = np.concatenate([moment.positions for moment in moments if moment.positions is not None])
        stamps, index = np.unique(np.concatenate([moment.stamps_ns for moment in moments]), return_index=True)
        return Moments(stamps, positions[index]), np.concatenate([line.as_stated for line in lines])[index]

    def is_fixed(self, source: str, target: str) -> bool:
        """Return whether all transforms between two frames are static (tf_static), and did not change so far."""
        path = self.path(source, target)
        if path is None:
            return False
        return all(
            self._line(frame, other)[0] is None and not self._static[frame if is_up else other].changes
            for frame, other in pairwise(path)
            for is_up in (self._line(frame, other)[1],)
        )

    def reaches(self, source: str, target: str, stamp_ns: int) -> bool:
        """Return whether all non-static transforms between two frames were stated for ``stamp_ns`` or later."""
        path = self.path(source, target)
        if path is None:
            return False
        lines = (self._line(frame, other)[0] for frame, other in pairwise(path))
        return all(line is None or line.latest_ns >= stamp_ns for line in lines)

    # The robot

    def base_of(self, sensor: str, hints: set[str]) -> str:
        """Return the robot's base frame for the frame of a sensor.

        It is the ancestor with a customary name; else the one named by an odometry message (``hints``); else the frame
        with a customary name that is fixed to the sensor in another way, as if a camera is the root; else the lowest
        frame that moves in its parent; else the sensor's frame itself.
        """
        chain = self.ancestors(sensor)
        last = [_last(frame) for frame in chain]
        for name in BASES:
            if name in last:
                return chain[last.index(name)]
        for frame in chain:
            if frame in hints:
                return frame
        fixed = self._fixed_base(sensor)
        if fixed is not None:
            return fixed
        lowest = next((frame for frame, other in pairwise(chain) if self._moves(frame, other)), None)
        # If the robot itself is the root, a fixed frame moves in it.
        return lowest or next((frame for frame in chain[1:] if self._has_fixed_child(frame)), sensor)

    def _has_fixed_child(self, frame: str) -> bool:
        """Return whether a frame named like a fixed one moves in another."""
        return any(is_fixed_name(child) and self._moves(frame, child) for child in self._children_of(frame))

    def _fixed_base(self, sensor: str) -> str | None:
        """Return the base rigidly connected to a sensor, in its namespace; None without one."""
        for name in BASES:
            frame = f"{sensor.rpartition('/')[0]}/{name}".lstrip("/")
            if self.knows(frame) and self._any_path(sensor, frame, rigid=True) is not None:
                return frame
        return None

    def base_apart(self, sensor: str, hints: set[str]) -> str | None:
        """Return the base of a robot whose ``sensor`` is a frame not connected to it by tf; None without one.

        It is a frame that :meth:`is_base` and moves in an ancestor, or in which a fixed frame moves. If there are
        several robots, it is the one in the sensor's namespace; None if there is not exactly one.
        """
        named = (*self._of_moving.children, *self._of_static.children)
        known = dict.fromkeys([*self._moving, *self._static, *named])
        bases = [frame for frame in known if self.is_base(frame, hints) and self.worlds(frame, only_moving=True)]
        robots = {frame.rpartition("/")[0] for frame in bases}
        robot = sensor.rpartition("/")[0] if len(robots) > 1 else next(iter(robots), "")
        ranks = {name: rank for rank, name in enumerate(BASES)}
        candidates = [frame for frame in bases if frame.rpartition("/")[0] == robot]
        return min(candidates, key=lambda frame: ranks.get(_last(frame), len(BASES)), default=None)

    @staticmethod
    def is_base(frame: str, hints: set[str]) -> bool:
        """Return whether a frame is named like a robot's base, or by an odometry message (``hints``)."""
        return _last(frame) in BASES or frame in hints

    def worlds(self, base: str, hints: Collection[str] = (), *, only_moving: bool = False) -> list[Path]:
        """Return the paths from ``base`` to the frames in which it moves, or that are named like fixed frames.

        These are ancestors via any stated parent. A frame named like a fixed one that moves in ``base`` or in an
        ancestor also counts, with its own ancestors, because some publish odometry as ``base_link → odom``. If ``base``
        moves in none, those count in which a frame fixed to it moves via another parent. ``map`` comes first, then the
        farthest, at most :data:`MAX_WORLDS`. With ``only_moving`` the base has to move in them. A frame named like a
        base, or by an odometry message (``hints``), belongs to the robot, even if ``base`` tilts or rises in it; so do
        the frames between the two.
        """
        up = list(self._paths_up((base,), moves=False))
        robot = {
            frame
            for path, _ in up
            for at, last in enumerate(path)
            if at and self.is_base(last, set(hints))
            for frame in path[: at + 1]
        }
        down: list[tuple[Path, bool]] = []
        for path, moves in [((base,), False), *up]:
            for child in self._children_of(path[-1]):
                if child not in path and is_fixed_name(child) and self._moves(path[-1], child):
                    down.append(((*path, child), True))
                    down += self._paths_up((*path, child), moves=True)
            if moves:
                break  # frames next to a moving one may be another robot's
        if not any(moves for _, moves in up):
            down += self._paths_beside(base)
        paths: dict[Path, None] = {}
        for path, moves in [*sorted(up, key=lambda item: -len(item[0])), *down]:
            if path[-1] not in robot and (moves or (not only_moving and _last(path[-1]) in WORLDS)):
                paths[path] = None
        return sorted(paths, key=lambda path: _last(path[-1]) != "map")[:MAX_WORLDS]

    def _paths_beside(self, base: str) -> Iterator[tuple[Path, bool]]:
        """Yield the paths via a frame that is fixed to ``base`` and moves in another parent of its own.

        An example is a tracking camera that is in ``base`` in the robot's description, and in a fixed frame in its
        driver.
        """
        level: list[Path] = [(base,)]
        for _ in range(MAX_DEPTH):
            level = [
                (*path, child)
                for path in level
                for child in self._children_of(path[-1])
                if child not in path and not self._moves(path[-1], child)
            ][:MAX_DEPTH]
            for path in level:
                for parent in self.parents(path[-1]):
                    if parent not in path and self._moves(path[-1], parent):
                        yield (*path, parent), True
                        yield from self._paths_up((*path, parent), moves=True)

    def _paths_up(self, path: Path, *, moves: bool) -> Iterator[tuple[Path, bool]]:
        """Yield the continuations of a path to the ancestors of its last frame, and whether anything moves along
        them.
        """
        todo = [(path, moves)]
        n = 0
        while todo and n < MAX_DEPTH * 4:
            path, moves = todo.pop()
            parents = self.parents(path[-1])
            if path[-1] not in self._moving:
                parents = parents[:1]  # static transforms replace each other
            for parent in reversed(parents):
                if parent not in path and len(path) < MAX_DEPTH:
                    n += 1
                    following = ((*path, parent), moves or self._moves(path[-1], parent))
                    yield following
                    todo.append(following)


def why_ignored(parent: str, child: str, pose: Pose7) -> str:
    """Return why tf2 ignores a transform; empty for a valid one."""
    if not parent or not child:
        return "it does not name its parent frame" if not parent else "it does not name its child frame"
    if parent == child:
        return "it is of a frame in itself"
    return why_no_pose(pose)


def is_fixed_name(frame: str) -> bool:
    """Return whether a frame is named like a fixed one: one of its words is map, odom or similar, or it is utm, …"""
    name = _last(frame).lower()
    return name in _WORLD_NAMES or bool(_WORLD_WORDS & set(re.split(r"[^a-z]+", name)))


def _last(frame: str) -> str:
    return frame.rsplit("/", 1)[-1]
