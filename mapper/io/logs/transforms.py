"""Poses over time, and the tree of frames that tf keeps: where a frame was in one of its ancestors.

Positions (n, 3) are metres, orientations (n, 4) unit quaternions x y z w. Source: REP 105; the tf2 design (tf2 looks a
transform up along the path to the common ancestor, interpolating each edge); Shoemake 1985 (slerp).
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.io.logs.message_fields import BadMessageError, Pose7
from mapper.io.logs.ros_messages import StampedPose
from mapper.sensors.robot_log import TransformEdge

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]
MAX_FRAMES = 5000
MAX_DEPTH = 64  #: frames from a sensor's up to the root
MAX_WORLDS = 8  #: fixed frames in which the robot's trajectory is given
_MOVED_M, _MOVED_RAD = 1e-3, 1e-3  #: an edge that never differs by more is a mount, not a motion
BASES = ("base_link", "base_footprint", "base", "base_frame")
WORLDS = ("map", "odom", "odom_combined", "world", "earth")


@dataclass(frozen=True, slots=True)
class Poses3:
    """``T_a_b`` at n times."""

    positions: Float64Array
    rotations: Float64Array

    def __matmul__(self, other: Poses3) -> Poses3:
        """Return ``T_a_c`` for ``T_a_b @ T_b_c``; one of them may have n = 1."""
        return Poses3(
            self.positions + _rotated(self.rotations, other.positions), _product(self.rotations, other.rotations)
        )

    @property
    def planar(self) -> Float64Array:
        """The poses seen from above (n, 3): x, y and the heading of the x axis."""
        ahead = _rotated(self.rotations, np.array([[1.0, 0.0, 0.0]]))
        return np.column_stack([self.positions[:, :2], np.arctan2(ahead[:, 1], ahead[:, 0])])

    @property
    def matrices(self) -> Float64Array:
        """The rotations as matrices (n, 3, 3)."""
        axes = [_rotated(self.rotations, axis[np.newaxis]) for axis in np.eye(3)]
        return np.stack(axes, axis=-1)

    @property
    def up(self) -> Float64Array:
        """The z component of the z axis (n,): 1 upright, −1 upside-down."""
        return np.asarray(_rotated(self.rotations, np.array([[0.0, 0.0, 1.0]]))[:, 2])


def _product(a: Float64Array, b: Float64Array) -> Float64Array:
    ax, ay, az, aw = a.T
    bx, by, bz, bw = b.T
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def _rotated(q: Float64Array, v: Float64Array) -> Float64Array:
    u, w = q[:, :3], q[:, 3:]
    t = 2.0 * np.cross(u, v)
    return np.asarray(v + w * t + np.cross(u, t))


class Timeline:
    """A pose that was stated at several times."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._stamps = array("q")
        self._values = array("d")
        self._in_order: tuple[Int64Array, Poses3] | None = None  #: made when first asked for
        self._is_ascending = True
        self.latest_ns = -(1 << 63)  #: the latest stamp

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp_ns: int, pose: Pose7) -> None:
        """Append one. Raises :class:`BadMessageError` for no place or no rotation, :class:`LimitError` for too many."""
        norm = sum(q * q for q in pose[3:])
        # Written so that nan fails, too.
        if not (max(map(abs, pose[:3])) <= self._limits.max_pose and abs(norm - 1.0) < 0.1 and sum(pose) == sum(pose)):
            raise BadMessageError
        if len(self._stamps) >= self._limits.max_messages:
            raise LimitError("log.too_many_poses", f"The log has more than {self._limits.max_messages} poses.")
        self._in_order = None
        self._is_ascending &= stamp_ns >= self.latest_ns
        self.latest_ns = max(self.latest_ns, stamp_ns)
        self._stamps.append(stamp_ns)
        self._values.extend(pose)

    def _sorted(self) -> tuple[Int64Array, Poses3]:
        if self._in_order is None:
            self._in_order = self._put_in_order()
        return self._in_order

    def _put_in_order(self) -> tuple[Int64Array, Poses3]:
        stamps = np.frombuffer(self._stamps, dtype=np.int64)
        values = np.frombuffer(self._values).reshape(-1, 7)
        if (np.diff(stamps) < 0).any():
            order = np.argsort(stamps, kind="stable")
            stamps, values = stamps[order], values[order]
        return stamps, _poses_of(values)

    def _around(self, stamps_ns: Int64Array) -> tuple[Int64Array, Poses3]:
        """Return the poses in their order; while they still come in, of one time, only the next ones to it."""
        if self._in_order is not None or len(stamps_ns) != 1 or not self._is_ascending:
            return self._sorted()
        at = bisect_right(self._stamps, int(stamps_ns[0]))
        first, last = max(0, at - 2), min(len(self._stamps), at + 2)
        values = np.array(self._values[7 * first : 7 * last]).reshape(-1, 7)
        return np.array(self._stamps[first:last], dtype=np.int64), _poses_of(values)

    def covers(self, stamps_ns: Int64Array) -> NDArray[np.bool_]:
        """Return which of the times (n,) are between the first and the last of these, to within 0.2 s."""
        stamps, _ = self._sorted()
        slack = 200_000_000
        return np.asarray((stamps_ns >= stamps[0] - slack) & (stamps_ns <= stamps[-1] + slack))

    def at(self, stamps_ns: Int64Array) -> Poses3:
        """Return the poses at n times: linear in position, along the shorter arc in rotation, nothing extrapolated."""
        stamps, poses = self._around(stamps_ns)
        if len(stamps) == 1:
            return poses
        high = np.clip(np.searchsorted(stamps, stamps_ns, side="right"), 1, len(stamps) - 1)
        low = high - 1
        span = (stamps[high] - stamps[low]).astype(np.float64)
        into = (stamps_ns - stamps[low]).astype(np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            w = np.where(span > 0.0, np.clip(into / span, 0.0, 1.0), 0.0)[:, None]
        positions = poses.positions[low] + w * (poses.positions[high] - poses.positions[low])
        return Poses3(positions, _slerp(poses.rotations[low], poses.rotations[high], w))

    @property
    def stated(self) -> tuple[Int64Array, Poses3]:
        """The stamps (n,) in their order, each once, and the poses then; of equal stamps the last stated counts."""
        stamps, poses = self._sorted()
        last = np.append(stamps[1:] != stamps[:-1], True)
        return stamps[last], Poses3(poses.positions[last], poses.rotations[last])

    @property
    def moves(self) -> bool:
        """Whether any pose differs from the first one."""
        _, poses = self._sorted()
        dots = np.abs(np.sum(poses.rotations * poses.rotations[0], axis=1))
        far = np.abs(poses.positions - poses.positions[0]).max() > _MOVED_M
        return bool(far or (2.0 * np.arccos(np.minimum(dots, 1.0))).max() > _MOVED_RAD)


def _poses_of(values: Float64Array) -> Poses3:
    """Return rows (n, 7), position and quaternion, as poses."""
    return Poses3(values[:, :3], values[:, 3:] / np.linalg.norm(values[:, 3:], axis=1, keepdims=True))


def _slerp(a: Float64Array, b: Float64Array, w: Float64Array) -> Float64Array:
    dot = np.sum(a * b, axis=1, keepdims=True)
    b = np.where(dot < 0.0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0.0, 1.0))
    sin = np.sin(angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.where(sin > 1e-6, np.sin((1.0 - w) * angle) / sin, 1.0 - w)
        right = np.where(sin > 1e-6, np.sin(w * angle) / sin, w)
    mixed = left * a + right * b
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))


class FrameTree:
    """Every transform that tf stated."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._parents: dict[str, dict[str, Timeline]] = {}  #: child → parent → T_parent_child
        self._static: set[tuple[str, str]] = set()  #: child, parent

    def add(self, one: StampedPose, *, is_static: bool = False) -> None:
        """Take one transform, ``is_static`` where it is said never to change.

        Raises :class:`BadMessageError`, :class:`LimitError`.
        """
        edges = self._parents.setdefault(one.child, {})
        if one.frame not in edges:
            if len(self._parents) + len(edges) > MAX_FRAMES:
                raise LimitError("log.too_many_frames", f"The log's tf tree has more than {MAX_FRAMES} frames.")
            edges[one.frame] = Timeline(self._limits)
        edges[one.frame].add(one.stamp_ns, one.pose)
        if is_static:
            self._static.add((one.child, one.frame))

    def transforms(self) -> tuple[TransformEdge, ...]:
        """Return what is stated of each pair of frames, by child and parent."""
        found = []
        for child, parents in sorted(self._parents.items()):
            for parent, edge in sorted(parents.items()):
                if len(edge):
                    stamps, _ = edge.stated
                    ends = (len(edge), int(stamps[0]), int(stamps[-1]))
                    found.append(TransformEdge(parent, child, (child, parent) in self._static, edge.moves, *ends))
        return tuple(found)

    def stamps(self, chain: list[str]) -> Int64Array:
        """Return the times (n,) at which anything that moves along the chain is stated, in their order, each once."""
        stated = [edge.stated[0] for edge in self.edges(chain) if edge.moves]
        return np.unique(np.concatenate(stated)) if stated else np.zeros(0, dtype=np.int64)

    @property
    def frames(self) -> int:
        """Number of frames that have a parent."""
        return len(self._parents)

    def ancestors(self, frame: str) -> list[str]:
        """Return ``frame``, its parent, and so on to the root; where several state to be the parent, the busiest is.

        Raises :class:`LimitError` for a chain that no robot has.
        """
        chain = [frame]
        while True:
            parents = {parent: edge for parent, edge in self._parents.get(chain[-1], {}).items() if len(edge)}
            parent = max(parents, key=lambda name: len(parents[name]), default=None)
            if parent is None or parent in chain:
                return chain
            if len(chain) >= MAX_DEPTH:
                raise LimitError(
                    "log.too_many_frames", f"In the log's tf tree a chain has more than {MAX_DEPTH} frames."
                )
            chain.append(parent)

    def loop_above(self, frame: str) -> list[str]:
        """Return the frames of a loop that ``frame``'s ancestors end in, each the child of the next; none without."""
        chain = self.ancestors(frame)
        parents = {parent: len(edge) for parent, edge in self._parents.get(chain[-1], {}).items() if len(edge)}
        parent = max(parents, key=lambda name: parents[name], default=None)
        return [] if parent is None else [*chain[chain.index(parent) :], parent]

    def edges(self, chain: list[str]) -> list[Timeline]:
        """Return the timelines from each of ``chain`` to the next, its parent."""
        return [self._parents[child][parent] for child, parent in pairwise(chain)]

    def lookup(self, chain: list[str], stamps_ns: Int64Array) -> Poses3:
        """Return where the first of ``chain`` was in the last, at n times (or once, where no edge of it moves)."""
        found = Poses3(np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]))
        for edge in self.edges(chain):
            found = edge.at(stamps_ns) @ found
        return found

    def is_fixed(self, chain: list[str]) -> bool:
        """Return whether everything along the chain was said never to change (tf_static)."""
        return all(pair in self._static for pair in pairwise(chain))

    def reaches(self, chain: list[str], stamp_ns: int) -> bool:
        """Return whether everything along the chain that may change was stated for ``stamp_ns`` or later."""
        return all(
            (child, parent) in self._static or self._parents[child][parent].latest_ns >= stamp_ns
            for child, parent in pairwise(chain)
        )

    def covers(self, chain: list[str], stamps_ns: Int64Array) -> NDArray[np.bool_]:
        """Return whether all that moves along the chain is known at each time (n,)."""
        covered = np.ones(len(stamps_ns), dtype=np.bool_)
        for edge in self.edges(chain):
            if edge.moves:
                covered &= edge.covers(stamps_ns)
        return covered

    def base_of(self, chain: list[str], hints: set[str]) -> int:
        """Return the index in ``chain``, which begins with a sensor's frame, of the robot's base.

        That is the frame of one of the customary names; else one that an odometry message names (``hints``); else the
        lowest frame that moves in its parent; else the sensor's frame itself.
        """
        last = [frame.rsplit("/", 1)[-1] for frame in chain]
        for name in BASES:
            if name in last:
                return last.index(name)
        for index, frame in enumerate(chain):
            if frame in hints:
                return index
        for index, edge in enumerate(self.edges(chain)):
            if edge.moves:
                return index
        return 0

    def base_apart(self, sensor: str, hints: set[str]) -> str | None:
        """Return the base of the robot whose ``sensor`` is a frame that tf does not connect to it; None without one.

        That is a frame that :meth:`is_base` and that moves in an ancestor. Of several robots, it is the one in the
        sensor's namespace; where none or several are, none.
        """
        found = [
            frame
            for frame in self._parents
            if self.is_base(frame, hints) and any(edge.moves for edge in self.edges(self.ancestors(frame)))
        ]
        robots = {frame.rpartition("/")[0] for frame in found}
        robot = sensor.rpartition("/")[0] if len(robots) > 1 else next(iter(robots), "")
        ranks = {name: rank for rank, name in enumerate(BASES)}
        candidates = [frame for frame in found if frame.rpartition("/")[0] == robot]
        return min(candidates, key=lambda frame: ranks.get(frame.rsplit("/", 1)[-1], len(BASES)), default=None)

    @staticmethod
    def is_base(frame: str, hints: set[str]) -> bool:
        """Return whether a frame is named as the robot's base is, or by an odometry message (``hints``)."""
        return frame.rsplit("/", 1)[-1] in BASES or frame in hints

    def worlds(self, chain: list[str]) -> list[str]:
        """Return the ancestors of ``chain``'s first frame in which it moves, or that are named as worlds are.

        ``map`` comes first, then from the root down, at most :data:`MAX_WORLDS`.
        """
        found = []
        moves = False
        for frame, edge in zip(chain[1:], self.edges(chain), strict=True):
            moves = moves or edge.moves
            if moves or frame.rsplit("/", 1)[-1] in WORLDS:
                found.append(frame)
        found.reverse()
        return sorted(found, key=lambda frame: frame.rsplit("/", 1)[-1] != "map")[:MAX_WORLDS]
