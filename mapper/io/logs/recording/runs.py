"""Restarts of a recording's clock: a simulation was reset, or a recording was played in a loop.

tf2 clears its buffer when ROS time jumps back (tf2_ros/buffer.cpp: Buffer::onTimeJump), so that no transform of one run
is ever applied to a scan of another. A recording has no such signal, only stamps, and its messages come from many
publishers: stamps of one may be behind those of another by a second, because those of amcl's transform are ahead
(transform_tolerance), and messages of one publisher may be late. So each topic is judged by its own stamps:

- It steps back if a stamp is more than :data:`LEAST_STEP_NS` behind the latest before it and the next :data:`STAYS`
  messages stay behind as well; a late message is followed by one that is not late.
- The clock restarted if, of all topics that continue there, more have stepped back than not. A driver that sets its own
  clock does not start another run.

A frame of tf is judged separately, because each may have its own publisher; of the frames of one topic the majority
counts as the topic.

A file whose messages are not stored in recording order, such as one from a program that merges recordings, is sorted
instead (:func:`is_in_disorder`), and so is one with parts in another order, such as files joined by name: each part was
recorded where another one ends (:func:`are_parts_of_one`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mapper.core.array_types import Int64Array

#: Smaller steps back are ignored: threads and buffers of one publisher reorder its messages by as much, tf2 sorts late
#: transforms, and all topics of 2 Hz and more see a larger step.
LEAST_STEP_NS = 500_000_000
STAYS = 3
NEAR_S = 5.0  #: time within which all topics have seen the clock restart
BETWEEN_NS = 1_000_000_000_000  #: between the last stamp of a run and the first of the next, after continuation
MAX_RUNS = 200
#: Fraction of the messages recorded before their predecessor, by more than :data:`LEAST_STEP_NS`, above which a file is
#: in disorder. If the recorder's clock is the simulation's, one message is so at a reset, and a few around it.
DISORDERED = 0.05
_FARTHEST_NS = 4_000_000_000_000_000_000  #: continued stamps beyond would not fit into 64 bits


@dataclass(frozen=True, slots=True)
class Track:
    """The stamps (n,) of one publisher of a topic, as far as known, and the indices of their messages (n,).

    ``recorded_ns`` (n,) are their recording times; None if unknown.
    """

    topic: str
    stamps_ns: Int64Array
    positions: Int64Array
    recorded_ns: Int64Array | None = None


def is_in_disorder(tracks: Sequence[Track]) -> bool:
    """Return whether the messages of a file are not stored in recording order."""
    known = [track for track in tracks if track.recorded_ns is not None and track.recorded_ns.all()]
    if not known:
        return False
    positions = np.concatenate([track.positions for track in known])
    recorded = np.concatenate([track.recorded_ns for track in known if track.recorded_ns is not None])
    back = np.count_nonzero(np.diff(recorded[np.argsort(positions, kind="stable")]) < -LEAST_STEP_NS)
    return bool(back > 1 and back > DISORDERED * len(recorded))


def is_out_of_order(tracks: Sequence[Track]) -> bool:
    """Return whether any message was recorded before one stored in front of it, if all of this is known."""
    if not tracks or not all(track.recorded_ns is not None and track.recorded_ns.all() for track in tracks):
        return False
    positions = np.concatenate([track.positions for track in tracks])
    recorded = np.concatenate([track.recorded_ns for track in tracks if track.recorded_ns is not None])
    return bool((np.diff(recorded[np.argsort(positions, kind="stable")]) < 0).any())


def are_parts_of_one(tracks: Sequence[Track], offsets: Sequence[Int64Array]) -> bool:
    """Return whether runs, given by the offsets of each track's stamps, are parts of one recording in another order.

    By their recording times each follows another within :data:`NEAR_S`, but they are not stored so; after a clock
    restart, times are repeated or differ.
    """
    if any(track.recorded_ns is None or not track.recorded_ns.all() for track in tracks):
        return False
    recorded = np.concatenate([track.recorded_ns for track in tracks if track.recorded_ns is not None])
    runs = np.concatenate(list(offsets))
    spans = [(int(recorded[runs == run].min()), int(recorded[runs == run].max())) for run in np.unique(runs)]
    in_time = sorted(spans)
    between = [after[0] - before[1] for before, after in pairwise(in_time)]
    return spans != in_time and all(0 <= step <= NEAR_S * 1e9 for step in between)


def steps_back(stamps_ns: Int64Array) -> list[int]:
    """Return the indices at which stamps (n,) step back and stay behind."""
    steps: list[int] = []
    start = 0
    while len(stamps_ns) - start > 1 and len(steps) < MAX_RUNS:
        part = stamps_ns[start:]
        latest = np.maximum.accumulate(part)[:-1]
        after = part[1:]
        highest = after.copy()  # maximum of each stamp and the next ones
        for ahead in range(1, STAYS + 1):
            highest[:-ahead] = np.maximum(highest[:-ahead], after[ahead:])
        back = np.flatnonzero((after < latest - LEAST_STEP_NS) & (highest < latest))
        if not len(back):
            break
        start += int(back[0]) + 1
        steps.append(start)
    return steps


def offsets_of_runs(tracks: Sequence[Track]) -> list[Int64Array] | None:
    """Return the offsets to add to the stamps of each track, so that each run follows the one before.

    None if the clock never restarted.
    """
    steps = [steps_back(track.stamps_ns) for track in tracks]
    if not any(steps):
        return None
    resets = [reset for reset in _clustered(tracks, steps) if _is_agreed(tracks, reset)][:MAX_RUNS]
    if not resets:
        return None
    starts = [_starts(track, number, resets) for number, track in enumerate(tracks)]
    ahead = [0]
    for run in range(1, len(resets) + 1):
        needed = 0
        for track, bounds in zip(tracks, starts, strict=True):
            before, after = (
                track.stamps_ns[bounds[run - 1] : bounds[run]],
                track.stamps_ns[bounds[run] : bounds[run + 1]],
            )
            if len(before) and len(after):
                needed = max(needed, int(before.max()) - int(after.min()) + BETWEEN_NS)
        ahead.append(ahead[-1] + needed)
        if ahead[-1] > _FARTHEST_NS:
            return None
    return [np.repeat(np.array(ahead, dtype=np.int64), np.diff(np.array(bounds))) for bounds in starts]


@dataclass(frozen=True, slots=True)
class _Reset:
    """A message index at which some tracks (by index) step back, at these of their stamps."""

    position: int
    steps: dict[int, int]
    step_ns: int
    near: int  #: messages within which others have seen it


def _clustered(tracks: Sequence[Track], steps: Sequence[Sequence[int]]) -> list[_Reset]:
    """Return the steps of different tracks that are near each other, in recording order."""
    events = sorted(
        (int(track.positions[index]), number, index)
        for number, (track, step) in enumerate(zip(tracks, steps, strict=True))
        for index in step
    )
    near = _messages_in(tracks, NEAR_S)
    groups: list[list[tuple[int, int, int]]] = []
    for event in events:
        is_next = not groups or event[0] - groups[-1][0][0] > near or event[1] in (known[1] for known in groups[-1])
        if is_next:
            groups.append([])
        groups[-1].append(event)
    passed = []
    for group in groups:
        back = [
            int(tracks[number].stamps_ns[:index].max()) - int(tracks[number].stamps_ns[index])
            for _, number, index in group
        ]
        position = group[len(group) // 2][0]
        passed.append(_Reset(position, {number: index for _, number, index in group}, int(np.median(back)), near))
    return passed


def _messages_in(tracks: Sequence[Track], seconds: float) -> int:
    """Return the usual number of messages in a time span."""
    positions = np.concatenate([track.positions for track in tracks])
    steps = np.concatenate([np.diff(track.stamps_ns) for track in tracks])
    passed_s = float(max((np.clip(np.diff(track.stamps_ns), 0, None).sum() for track in tracks), default=0)) * 1e-9
    if passed_s <= 0.0 or not len(steps):
        return 1
    return max(20, int(seconds * float(np.ptp(positions)) / passed_s))


def _is_agreed(tracks: Sequence[Track], reset: _Reset) -> bool:
    """Return whether more of the topics that continue at a place step back there than not."""
    for_it: dict[str, int] = {}
    for number, track in enumerate(tracks):
        at = int(np.searchsorted(track.positions, reset.position))
        if number in reset.steps:
            for_it[track.topic] = for_it.get(track.topic, 0) + 1
        elif 0 < at < len(track.positions) and track.positions[at] - reset.position <= reset.near:
            usual = float(np.median(np.abs(np.diff(track.stamps_ns)))) if len(track.stamps_ns) > 1 else 0.0
            if (STAYS + 2) * usual < reset.step_ns:  # otherwise the track is inconclusive
                for_it[track.topic] = for_it.get(track.topic, 0) - 1
    return sum((votes > 0) - (votes < 0) for votes in for_it.values()) > 0


def _starts(track: Track, number: int, resets: Sequence[_Reset]) -> list[int]:
    """Return the index of a track's first stamp of each run, and finally its number of stamps."""
    starts = [0]
    for reset in resets:
        at = reset.steps.get(number)
        at = int(np.searchsorted(track.positions, reset.position)) if at is None else at
        starts.append(max(starts[-1], at))
    return [*starts, len(track.stamps_ns)]
