"""The doctor's events on simulated drives in which it is known what happened: found, missed and false ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mapper.diagnosis.events import Event, find_events
from tests.bench.event_runs import RATE_HZ, Happening, drive, free_scans

N = 600  #: scans of a drive, two minutes
HALVES = {"calibration": (("office", 1), ("loop", 2), ("maze", 1)), "check": (("hall", 3), ("room", 4), ("office", 5))}
NEAR_S = 1.0  #: of the true time, within which an event is the one that happened


@dataclass(frozen=True, slots=True)
class Block:
    """Cases of one row of the table: what happens, and how large it is; ``kind`` is empty where nothing happens."""

    title: str
    kind: str
    lasts: int
    sizes: tuple[tuple[float, float, float], ...]
    drift: float = 0.5


BLOCKS: tuple[Block, ...] = (
    Block("nothing, exact wheels", "", 0, ((0.0, 0.0, 0.0),), 0.0),
    Block("nothing, good wheels", "", 0, ((0.0, 0.0, 0.0),), 1.0),
    Block("nothing, poor wheels", "", 0, ((0.0, 0.0, 0.0),), 4.0),
    Block("pushed 0.10 m", "pushed", 1, ((0.0, 0.1, 0.0), (-0.1, 0.0, 0.0))),
    Block("pushed 0.15 m", "pushed", 1, ((0.0, 0.15, 0.0), (-0.15, 0.0, 0.0))),
    Block("pushed 0.25 m", "pushed", 2, ((0.0, -0.25, 0.0), (-0.25, 0.0, 0.0))),
    Block("pushed 0.40 m", "pushed", 2, ((0.0, 0.4, 0.0), (0.0, -0.4, 0.0))),
    Block("pushed 0.40 m, poor wheels", "pushed", 2, ((0.0, 0.4, 0.0), (0.0, -0.4, 0.0)), 4.0),
    Block("pushed 0.80 m", "pushed", 3, ((0.0, 0.8, 0.0), (-0.8, 0.0, 0.0))),
    Block("turned by 20°", "pushed", 2, ((0.0, 0.0, math.radians(20.0)), (0.0, 0.0, math.radians(-20.0)))),
    Block("slipped 0.30 m in 1 s", "slipped", 5, ((0.3, 0.0, 0.0),)),
    Block("slipped 0.60 m in 2 s", "slipped", 10, ((0.6, 0.0, 0.0),)),
    Block("slipped 1.20 m in 3 s", "slipped", 15, ((1.2, 0.0, 0.0),)),
    Block("slipped 1.20 m in 3 s, poor wheels", "slipped", 15, ((1.2, 0.0, 0.0),), 4.0),
    Block("lifted, set down 0.6 m away", "lifted", 12, ((0.2, -0.57, 1.2), (0.0, 0.6, -2.0))),
    Block("clock set back by 1.5 s", "clock", 1, ((-1.5, 0.0, 0.0),)),
    Block("clock set forward by 60 s", "clock", 1, ((60.0, 0.0, 0.0),)),
)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Of one drive: whether what happened was found, under its right kind, and the events that did not happen."""

    found: bool
    named: bool
    false: int
    metres_off: float | None
    seconds_off: float | None


def outcome(happening: Happening | None, events: Sequence[Event]) -> Outcome:
    """Compare the events of a drive with what happened."""
    if happening is None:
        return Outcome(False, False, len(events), None, None)
    begin, end = happening.at / RATE_HZ, (happening.at + happening.lasts) / RATE_HZ
    near = [one for one in events if one.until_s >= begin - NEAR_S and one.seconds <= end + NEAR_S]
    if not near:
        return Outcome(False, False, len(events), None, None)
    one = near[0]
    sign = -1.0 if happening.kind == "slipped" else 1.0
    off = None
    if one.ahead_m is not None and one.left_m is not None and happening.kind != "clock":
        off = math.hypot(one.ahead_m - sign * happening.moved[0], one.left_m - sign * happening.moved[1])
    return Outcome(True, one.kind == happening.kind, len(events) - 1, off, abs(one.seconds - begin))


def cases(block: Block, drives: Sequence[tuple[str, int]]) -> Iterator[Outcome]:
    """Yield the outcomes of a block on some drives."""
    for number, (world, seed) in enumerate(drives):
        for moved in block.sizes:
            if not block.kind:
                yield outcome(None, find_events(drive(world, N, seed=seed, drift=block.drift)))
                continue
            moves = block.kind in ("pushed", "lifted")
            free = free_scans(world, N, seed, moved if moves else (0.0, 0.0, 0.0))
            if not len(free):
                continue
            scan = int(np.random.default_rng(100 * number + seed).choice(free))
            happening = Happening(block.kind, scan, block.lasts, moved)
            yield outcome(happening, find_events(drive(world, N, [happening], seed=seed, drift=block.drift)))


def events() -> None:
    """Print the table of docs/figures.md: the drives with which thresholds were chosen, and others."""
    print("| what happens | drives | found | named rightly | metres off | seconds off | false events |")
    print("|---|---|---|---|---|---|---|")
    for half, drives in HALVES.items():
        for block in BLOCKS:
            all_of = list(cases(block, drives))
            found = [one for one in all_of if one.found]
            metres = [one.metres_off for one in found if one.metres_off is not None]
            times = [one.seconds_off for one in found if one.seconds_off is not None]
            shown = [
                f"{half}: {block.title}",
                str(len(all_of)),
                str(len(found)) if block.kind else "–",
                str(sum(one.named for one in found)) if block.kind else "–",
                f"{np.median(metres):.2f}" if metres else "–",
                f"{np.median(times):.1f}" if times else "–",
                str(sum(one.false for one in all_of)),
            ]
            print(f"| {' | '.join(shown)} |", flush=True)
