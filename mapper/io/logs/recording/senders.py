"""Two programs that state the same transform in turns, such as the wheels and a filter: which sent which.

tf2 keeps one transform of a frame in another and jumps between the two. No message says who sent it, but each sender
goes on from where its own last transform was.
"""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array

LEAST = 20  #: transforms, and changes from one sender to the other
MOST = 400_000  #: transforms that are looked at
LEAST_JUMP = 0.03  #: metres, or radians, between the two senders
JUMP = 5.0  #: of a usual step, from which a transform may be of another sender
SHORTER = 0.2  #: of the way through all transforms: the ways of two senders together
LEAST_SHARE = 0.05  #: of the transforms, that each sender has
LEAST_SPAN = 0.5  #: of the transforms, between the first and the last of each sender


def senders_of(poses: Float64Array) -> tuple[BoolArray, BoolArray] | None:
    """Return which poses (n, 7) in the order of their messages are of a first sender and of a second; None for one.

    The second is the one that moves less or, where both move alike, that has fewer. What comes before they part is of
    both. A pose is x, y, z and a unit quaternion. Distances are metres and radians in sum.
    """
    n = len(poses)
    if not 2 * LEAST <= n <= MOST:
        return None
    one, two = apart(poses[1:], poses[:-1]), apart(poses[2:], poses[:-2])
    jump = max(LEAST_JUMP, JUMP * float(np.median(np.minimum(one[:-1], two))))
    if np.count_nonzero(one > jump) < LEAST:
        return None
    is_b = _followed(poses, int(np.argmax(one)))
    switches = int(np.count_nonzero(is_b[1:] != is_b[:-1]))
    own = [np.flatnonzero(~is_b), np.flatnonzero(is_b)]
    if switches < LEAST or min(map(len, own)) < max(LEAST, LEAST_SHARE * n):
        return None
    ways = [float(apart(poses[k[1:]], poses[k[:-1]]).sum()) for k in own]
    if sum(ways) > SHORTER * float(one.sum()) or min(int(k[-1] - k[0]) for k in own) < LEAST_SPAN * n:
        return None
    later = max(own[0][0], own[1][0])
    step = max(way / len(k) for way, k in zip(ways, own, strict=True))
    before = np.arange(n) < (later if apart(poses[later], poses[later - 1]) <= max(jump, 2.0 * step) else 0)
    both = (~is_b | before, is_b | before)
    b_is_second = ways[1] < 0.5 * ways[0] or (ways[1] < 2.0 * ways[0] and len(own[1]) <= len(own[0]))
    return both if b_is_second else both[::-1]


def apart(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return how far poses (..., 7) are from others: metres and radians in sum."""
    turned = 2.0 * np.arccos(np.minimum(np.abs(np.sum(a[..., 3:] * b[..., 3:], axis=-1)), 1.0))
    return np.asarray(np.linalg.norm(a[..., :3] - b[..., :3], axis=-1) + turned)


def _followed(poses: Float64Array, at: int) -> BoolArray:
    """Return which poses are of the sender of pose ``at``, the rest being of that of the next one.

    From there back and on, each is of the sender whose pose before was nearer.
    """
    is_b = np.zeros(len(poses), dtype=np.bool_)
    is_b[at] = True
    rows = poses.tolist()
    for way in (range(at - 1, -1, -1), range(at + 2, len(rows))):
        a, b = rows[at + 1], rows[at]
        for k in way:
            row = rows[k]
            if _near(row, b) < _near(row, a):
                is_b[k], b = True, row
            else:
                a = row
    return is_b


def _near(a: list[float], b: list[float]) -> float:
    """Return a measure that grows with :func:`apart`, of two poses."""
    dot = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6]
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2 + 4.0 * (1.0 - dot * dot)
