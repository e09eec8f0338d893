"""Clocks that are set while a recording is made, each by itself, as that of a lidar's computer by a time server.

The stamps of its sender step then, while its messages go on being recorded at their usual intervals. Messages that are
recorded late, and those of a sender that pauses, are no such step. Where most other topics step as well, the common
clock was set, or has begun again (:mod:`mapper.io.logs.recording.runs`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.io.logs.recording.clocks import FAR_NS
from mapper.io.logs.recording.runs import NEAR_S, Track

LEAST_NS = 500_000_000  #: by which a clock is set; less is what threads and networks disorder
REGULAR, SHARE = 0.25, 0.8  #: the share of the intervals that are so near to the usual one, of a regular sender
AROUND = 5  #: messages before and after a step, whose stamps have to differ by it from when they were recorded
ALIKE = 0.25  #: of a step: by as much may what is recorded say another one
MOST = 20  #: steps of one sender; a clock that is set more often is no clock


def settings_of(track: Track) -> list[tuple[int, int]]:
    """Return before which messages the clock of a sender was set, by index, and by how many nanoseconds."""
    recorded, stamps = track.recorded_ns, track.stamps_ns
    if recorded is None or not recorded.all() or len(stamps) <= 2 * AROUND:
        return []
    stated, came = np.diff(stamps), np.diff(recorded)
    usual = int(np.median(stated))
    if usual <= 0 or np.mean(np.abs(stated - usual) < REGULAR * usual) < SHARE:
        return []
    if abs(float(np.median(came)) - usual) > REGULAR * usual:  # as of a simulation that is slower than the recorder
        return []
    by = stated - usual
    steps = np.flatnonzero((np.abs(by) > LEAST_NS) & (np.abs(came - usual) < ALIKE * np.abs(by)))
    settings = [(int(k) + 1, int(by[k])) for k in steps]
    settings = [(at, step) for at, step in settings if _is_step(stamps - recorded, at, step)]
    return settings if len(settings) <= MOST else []


def as_never_set(stamps_ns: Int64Array, recorded_ns: Int64Array, settings: Sequence[tuple[int, int]]) -> Int64Array:
    """Return the stamps (n,) of a sender by its clock as it was while it was nearest to the recorder's.

    Of a clock that is far from that, as a simulation's, as it was at first.
    """
    shift = np.zeros(len(stamps_ns), dtype=np.int64)
    for at, step in settings:
        shift[at:] -= step
    parts = np.split(stamps_ns - recorded_ns, [at for at, _ in settings])
    ahead = [abs(float(np.median(part))) for part in parts]
    nearest = int(np.argmin(ahead)) if min(ahead) < FAR_NS else 0
    return np.asarray(stamps_ns + shift - shift[0 if nearest == 0 else settings[nearest - 1][0]])


def own_settings(tracks: Sequence[Track]) -> list[list[tuple[int, int]]]:
    """Return those of :func:`settings_of` of each sender that at most as many other topics share as go on there."""
    return [[setting for setting in settings_of(track) if _is_alone(track, setting, tracks)] for track in tracks]


def _is_step(ahead_ns: Int64Array, at: int, step: int) -> bool:
    """Return whether stamps are by a step farther ahead of when they were recorded (n,) from index ``at`` on."""
    before, after = ahead_ns[max(0, at - AROUND) : at], ahead_ns[at : at + AROUND]
    enough = min(len(before), len(after)) > 1
    return bool(enough and abs(float(np.median(after)) - float(np.median(before)) - step) < ALIKE * abs(step))


def _is_alone(track: Track, setting: tuple[int, int], tracks: Sequence[Track]) -> bool:
    at, step = setting
    votes: dict[str, bool] = {}
    when = 0 if track.recorded_ns is None else int(track.recorded_ns[at])
    for other in tracks:
        recorded = other.recorded_ns
        if other.topic == track.topic or recorded is None or not recorded.all():
            continue
        k = int(np.searchsorted(recorded, when))
        if 0 < k < len(recorded) and recorded[k] - recorded[k - 1] < NEAR_S * 1e9:
            votes[other.topic] = votes.get(other.topic, False) or _is_step(other.stamps_ns - recorded, k, step)
    shared = sum(votes.values())
    return bool(votes) and shared <= len(votes) - shared
