"""A pose stated at several times in a recording."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Int64Array
from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.io.logs.recording.clocks import with_set_stamps
from mapper.io.logs.recording.poses3 import Poses3, interpolated, poses_of, why_no_pose
from mapper.io.logs.recording.runs import LEAST_STEP_NS
from mapper.io.logs.recording.senders import senders_of
from mapper.io.logs.ros.message_fields import BadMessageError, Pose7

LEAST_APART_NS = 1_000_000  #: minimum mean interval for recording times to be used as message times
LEAST_ALIKE = 3  #: messages with equal stamps that indicate a fault of their sender
HARDLY = 0.05  #: of the time between two messages: smaller differences of stamps hardly advance
REGULAR = 2.0  #: ratio of the longer to the shorter recording intervals of regular messages
SAME_STAMP = "have the same stamp"
SLACK_NS = 200_000_000  #: before the first and after the last pose, within which the nearest may be used
_SLACK_M, _SLACK_RAD = 0.05, 0.02  #: maximum motion of the robot in this time, from its speed there
_MOVED_M, _MOVED_RAD = 1e-3, 1e-3  #: a pose that never differs by more is a mount, not a motion


@dataclass(frozen=True, slots=True)
class Moments:
    """n times of a recording: ``stamps_ns`` (n,), continued across clock restarts, see :mod:`.runs`.

    ``positions`` (n,) are the indices of their messages in recording order, or their recording times; None if unknown,
    which means after all messages.
    """

    stamps_ns: Int64Array
    positions: Int64Array | None = None

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, which: NDArray[np.bool_] | slice) -> Moments:
        return Moments(self.stamps_ns[which], None if self.positions is None else self.positions[which])

    def __add__(self, ahead_ns: int) -> Moments:
        return Moments(self.stamps_ns + ahead_ns, self.positions)


def why_no_stamps(stamps_ns: Int64Array, recorded_ns: Int64Array, differ: NDArray[np.bool_]) -> str:
    """Return why the stamps (n,) of one sender do not distinguish its messages; nothing if they do.

    Most equal that of the previous message, although the two messages differ: the clock stands still, or counts whole
    seconds. Or most are hardly later than the previous one, although the messages were recorded at regular intervals
    and the stamps as a whole advance at their rate: fractions of a second were stated in another unit. ``differ`` (n −
    1,) marks the messages that differ from the previous one. The recording times (n,), 0 if unknown, have to be as far
    apart as messages are.
    """
    n = len(stamps_ns)
    if n < LEAST_ALIKE or not recorded_ns.all() or np.ptp(recorded_ns) < LEAST_APART_NS * (n - 1):
        return ""
    steps, recorded = np.diff(stamps_ns), np.diff(recorded_ns)

    def are_most(standing: NDArray[np.bool_]) -> bool:
        return bool((LEAST_ALIKE - 1) * (n - 1) <= LEAST_ALIKE * np.count_nonzero(standing))

    if are_most((steps == 0) & differ):
        different = len(np.unique(stamps_ns))
        return SAME_STAMP if different == 1 else f"have no more than {different} different stamps"
    hardly = np.abs(steps) <= HARDLY * recorded
    least, most = np.quantile(recorded, (0.1, 0.9))
    rate = float(np.ptp(stamps_ns)) / float(np.ptp(recorded_ns))
    if are_most(hardly) and most <= REGULAR * least and 1.0 / REGULAR <= rate <= REGULAR:
        groups = 1 + int(np.count_nonzero(~hardly))
        return f"have stamps in {groups} groups, in each of which they hardly go on"
    return ""


class Timeline:
    """A pose stated at several times, stored like a transform in tf2's TimeCache: late messages are sorted in.

    While a recording is read, only poses since the last clock restart are interpolated (:meth:`at`); afterwards
    :meth:`count_on` makes all stamps ascend from run to run.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._stamps = array("q")
        self._positions = array("q")
        self._recorded = array("q")  #: recording times, 0 if unknown
        self._values = array("d")
        self._offsets: Int64Array | None = None  #: added to the stamps after clock restarts
        self._in_order: tuple[Int64Array, Poses3, Int64Array] | None = None  #: computed on first use
        self._moves: bool | None = None  #: determined on first use
        self._is_ascending = True
        self._run_from = 0  #: index of the first pose since the last clock restart
        self._before_ns = -(1 << 63)  #: the latest stamp before that
        self.latest_ns = -(1 << 63)  #: the latest stamp since then

    def __len__(self) -> int:
        return len(self._stamps)

    def add(self, stamp_ns: int, pose: Pose7, position: int = 0, recorded_ns: int = 0) -> None:
        """Append one, stated in the message with index ``position`` of the recording, recorded at ``recorded_ns``.

        Raises :class:`BadMessageError`, with the reason, for an invalid pose, and :class:`LimitError` for too many.
        """
        why = why_no_pose(pose)
        if why:
            raise BadMessageError(why)
        if len(self._stamps) >= self._limits.max_messages:
            raise LimitError("log.too_many_poses", f"The log has more than {self._limits.max_messages} poses.")
        self._in_order = self._moves = None
        if self._run_from and stamp_ns >= self._before_ns:  # the supposed run consisted of late messages
            self._run_from, self._is_ascending = 0, False
        elif len(self._stamps) and stamp_ns < self.latest_ns - LEAST_STEP_NS:
            self._run_from, self._is_ascending = len(self._stamps), True
            self._before_ns, self.latest_ns = max(self._before_ns, self.latest_ns), stamp_ns
        self._is_ascending &= stamp_ns >= self.latest_ns
        self.latest_ns = max(self.latest_ns, stamp_ns)
        self._stamps.append(stamp_ns)
        self._positions.append(position)
        self._recorded.append(recorded_ns)
        self._values.extend(pose)

    def by_sender(self) -> tuple[Timeline, Timeline] | None:
        """Return the poses of two senders that state them in turns; None where there is one.

        They are looked at in the order in which they were recorded; see :mod:`mapper.io.logs.recording.senders`.
        """
        poses = np.array(self._values).reshape(-1, 7)
        order = np.argsort(np.array(self._recorded), kind="stable")
        found = senders_of(poses[order])
        if found is None:
            return None
        parts = Timeline(self._limits), Timeline(self._limits)
        for part, own in zip(parts, found, strict=True):
            for k in np.sort(order[own]).tolist():
                part.add(self._stamps[k], tuple(poses[k].tolist()), self._positions[k], self._recorded[k])
        return parts

    @property
    def track(self) -> tuple[Int64Array, Int64Array, Int64Array]:
        """The stamps (n,) as stated, the indices of their messages (n,) and their recording times (n,).

        They are in recording order.
        """
        return (
            np.array(self._stamps, dtype=np.int64),
            np.array(self._positions, dtype=np.int64),
            np.array(self._recorded, dtype=np.int64),
        )

    def take_recorded_times(self) -> str:
        """Use the recording times of the poses if their stamps do not distinguish them.

        Return what is wrong with the stamps, nothing if they are kept: see :func:`why_no_stamps`.
        """
        stamps, values = np.array(self._stamps, dtype=np.int64), np.array(self._values).reshape(-1, 7)
        differ = (values[1:] != values[:-1]).any(axis=1)
        recorded = np.array(self._recorded, dtype=np.int64)
        why = why_no_stamps(stamps, recorded, differ)
        if why:
            self.set_to(recorded)
        return why

    def set_stamps(self) -> None:
        """Set the stamps of poses without one by the clock of the others: see :func:`with_set_stamps`."""
        corrected = with_set_stamps(np.array(self._stamps, dtype=np.int64), np.array(self._recorded, dtype=np.int64))
        if corrected is not None:
            self.set_to(corrected)

    def set_to(self, stamps_ns: Int64Array) -> None:
        """Replace the stamps (n,), in recording order."""
        self._stamps, self._in_order, self._moves = array("q", stamps_ns.tolist()), None, None
        self._run_from, self._is_ascending = 0, False

    @property
    def has_runs(self) -> bool:
        """Whether the clock restarted between its poses."""
        return self._offsets is not None and bool((self._offsets != self._offsets[0]).any())

    @property
    def last_position(self) -> int:
        """The index of the last message, −1 without one."""
        return self._positions[-1] if self._positions else -1

    def count_on(self, offsets: Int64Array) -> None:
        """Add offsets to the stamps (n,), so that each run follows the one before."""
        self._offsets, self._in_order, self._run_from, self._is_ascending = offsets, None, 0, False
        self._moves = None

    def put_in_order(self, *, by_recording: bool) -> None:
        """Sort all poses, even if their stamps stepped back, because the clock of the recording did not.

        With ``by_recording`` their messages are positioned by recording time, not by their place in the file.
        """
        if by_recording:
            order = np.argsort(np.array(self._recorded), kind="stable")
            self._stamps = array("q", np.array(self._stamps)[order].tobytes())
            self._recorded = array("q", np.array(self._recorded)[order].tobytes())
            self._values = array("d", np.array(self._values).reshape(-1, 7)[order].tobytes())
            self._positions = self._recorded[:]
        if by_recording or self._run_from:
            self._in_order, self._run_from, self._is_ascending, self._moves = None, 0, False, None

    def _sorted(self) -> tuple[Int64Array, Poses3, Int64Array]:
        if self._in_order is None:
            self._in_order = self._put_in_order()
        return self._in_order

    def _put_in_order(self) -> tuple[Int64Array, Poses3, Int64Array]:
        """Return the sorted stamps (n,), the poses, and the indices of their messages (n,)."""
        first = self._run_from
        stamps = np.array(self._stamps[first:], dtype=np.int64)
        if self._offsets is not None:
            stamps += self._offsets
        values = np.array(self._values[7 * first :]).reshape(-1, 7)
        order = np.arange(len(stamps))
        if (np.diff(stamps) < 0).any():
            order = np.argsort(stamps, kind="stable")
            stamps, values = stamps[order], values[order]
        return stamps, poses_of(values), order + first

    def _around(self, stamps_ns: Int64Array) -> tuple[Int64Array, Poses3]:
        """Return the sorted poses; for a single time while reading, only the adjacent ones."""
        if self._in_order is not None or len(stamps_ns) != 1 or not self._is_ascending:
            return self._sorted()[:2]
        at = bisect_right(self._stamps, int(stamps_ns[0]), self._run_from)
        first, last = max(self._run_from, at - 2), min(len(self._stamps), at + 2)
        values = np.array(self._values[7 * first : 7 * last]).reshape(-1, 7)
        return np.array(self._stamps[first:last], dtype=np.int64), poses_of(values)

    def covers(self, stamps_ns: Int64Array) -> NDArray[np.bool_]:
        """Return which of the times (n,) are between the first and the last of these.

        Up to :data:`SLACK_NS` before and after, the nearest pose also counts if it hardly changes meanwhile.
        """
        stamps, poses, _ = self._sorted()
        before, after = self._slack_ns(stamps, poses)
        inside = (stamps_ns >= stamps[0] - before) & (stamps_ns <= stamps[-1] + after)
        if self._offsets is not None and len(stamps) > 1:
            high = np.clip(np.searchsorted(stamps, stamps_ns, side="right"), 1, len(stamps) - 1)
            to_nearest = np.minimum(np.abs(stamps_ns - stamps[high - 1]), np.abs(stamps[high] - stamps_ns))
            inside &= (to_nearest <= SLACK_NS) | ~self._are_apart(high - 1, high)
        return np.asarray(inside)

    def _slack_ns(self, stamps: Int64Array, poses: Poses3) -> tuple[int, int]:
        """Return how long before the first and after the last pose these are near enough, from the speeds there."""
        last = len(stamps) - 1
        slacks = []
        for end, other in (
            (0, min(int(np.searchsorted(stamps, stamps[0] + SLACK_NS)), last)),
            (last, max(int(np.searchsorted(stamps, stamps[-1] - SLACK_NS, side="right")) - 1, 0)),
        ):
            passed = abs(int(stamps[other]) - int(stamps[end]))
            moved = float(np.linalg.norm(poses.positions[other] - poses.positions[end]))
            dot = min(abs(float(poses.rotations[other] @ poses.rotations[end])), 1.0)
            share = max(moved / _SLACK_M, 2.0 * float(np.arccos(dot)) / _SLACK_RAD)
            slacks.append(min(SLACK_NS, int(passed / share)) if share > 0.0 else SLACK_NS)
        return slacks[0], slacks[1]

    def _are_apart(self, low: Int64Array, high: Int64Array) -> NDArray[np.bool_]:
        """Return whether poses at these positions in the order (n,) belong to two runs."""
        if self._offsets is None:
            return np.zeros(len(low), dtype=np.bool_)
        *_, order = self._sorted()
        return np.asarray(self._offsets[order[low]] != self._offsets[order[high]])

    def at(self, stamps_ns: Int64Array) -> Poses3:
        """Return the poses at n times, or one for all: linear in position, along the shorter arc in rotation.

        There is no extrapolation, and no interpolation between two runs.
        """
        stamps, poses = self._around(stamps_ns)
        if len(stamps) == 1:
            return poses
        high = np.clip(np.searchsorted(stamps, stamps_ns, side="right"), 1, len(stamps) - 1)
        low = high - 1
        span = (stamps[high] - stamps[low]).astype(np.float64)
        into = (stamps_ns - stamps[low]).astype(np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            w = np.where(span > 0.0, np.clip(into / span, 0.0, 1.0), 0.0)
        if self._offsets is not None:
            w = np.where(self._are_apart(low, high), np.rint(w), w)
        return interpolated(poses[low], poses[high], w)

    @property
    def in_order(self) -> tuple[Moments, Poses3]:
        """The poses in time order, each time once; of several at one time the last stated is used."""
        stamps, poses, order = self._sorted()
        last = np.append(stamps[1:] != stamps[:-1], True)
        positions = np.array(self._positions, dtype=np.int64)[order[last]]
        return Moments(stamps[last], positions), poses[last]

    @property
    def as_stated(self) -> Int64Array:
        """The stamps (n,) of :attr:`in_order` as stated."""
        stamps, _, order = self._sorted()
        last = np.append(stamps[1:] != stamps[:-1], True)
        return np.asarray(np.array(self._stamps, dtype=np.int64)[order[last]])

    @property
    def moves(self) -> bool:
        """Whether any pose differs from the first one."""
        if self._moves is None:
            _, poses, _ = self._sorted()
            dots = np.abs(np.sum(poses.rotations * poses.rotations[0], axis=1))
            far = np.abs(poses.positions - poses.positions[0]).max() > _MOVED_M
            self._moves = bool(far or (2.0 * np.arccos(np.minimum(dots, 1.0))).max() > _MOVED_RAD)
        return self._moves
