"""``python -m tests.load NAME``: what sessions cost under load, over real sockets, beside an echo server."""

from __future__ import annotations

import sys

from tests.load.ending import ending
from tests.load.fairness import fairness
from tests.load.followers import followers
from tests.load.footprint import footprint
from tests.load.greedy import greedy
from tests.load.killed import killed
from tests.load.limited import limited
from tests.load.memory import memory
from tests.load.sessions import services, sessions, workers
from tests.load.soak import soak
from tests.load.ticks import ticks

RUNS = {
    "ticks": ticks,
    "sessions": sessions,
    "services": services,
    "workers": workers,
    "limited": limited,
    "followers": followers,
    "fairness": fairness,
    "greedy": greedy,
    "memory": memory,
    "footprint": footprint,
    "ending": ending,
    "killed": killed,
    "soak": soak,
}


def main() -> None:
    """Run what the first argument names; others are numbers of sessions, followers, minutes or repetitions."""
    name, numbers = (sys.argv[1] if len(sys.argv) > 1 else ""), sys.argv[2:]
    if name not in RUNS or not all(number.isdigit() for number in numbers):
        sys.exit(f"python -m tests.load {'|'.join(RUNS)} [NUMBER...]")
    RUNS[name](*map(int, numbers))


if __name__ == "__main__":
    main()
