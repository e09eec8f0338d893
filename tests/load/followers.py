"""Many followers of one session, a tenth of them stalled, beside an echo server on the same sockets."""

from __future__ import annotations

import os

from tests.load.served import echo, figures, service
from tests.load.sessions import HEAD, row, streams
from tests.load.viewer import PERIOD_S


def followers(*counts: int) -> None:
    """Print what the followers saw and what it cost, for these numbers of followers."""
    print(f"load {os.getloadavg()[0]:.1f} before the run; 10 looks a second, 1 of 10 followers stalled")
    print(HEAD)
    for count in counts or (300,):
        with service(4, count + 1) as process:
            ours = figures([process], streams(process.port, 1) * count, count // 10, PERIOD_S)
        with echo(ours.text_bytes, ours.tile_bytes) as process:
            theirs = figures([process], [(process.port, "/")] * count, count // 10, PERIOD_S)
        print(row(f"{count} followers", ours))
        print(row(f"{count} echoes", theirs))
        print(f"{'ratio':<20}{'':>55}{ours.us_per_frame / theirs.us_per_frame:>11.1f}", flush=True)
