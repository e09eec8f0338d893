"""SLAM of a session: of a simulated robot while it drives, or the pose graph of a log's trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from server.sessions.part import Offers, Part


def part_of(offers: Offers) -> Part | None:
    """Return the part of a simulation or a log."""
    if offers.simulation is not None:
        from server.parts.slam.live import SlamView  # noqa: PLC0415 - only of simulations

        return SlamView(offers.simulation)
    if offers.recording is None or offers.update_log is None:
        return None
    from server.parts.slam.graph import LogGraph  # noqa: PLC0415 - only of logs

    return LogGraph(offers.host, offers.recording, offers.update_log)
