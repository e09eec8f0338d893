"""The localization of a session: of a simulated robot while it drives, or of a log by a job."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from server.sessions.part import Offers, Part


def part_of(offers: Offers) -> Part | None:
    """Return the part for a simulation or a log. A log's part offers the map in which the log is localized."""
    if offers.simulation is not None:
        from server.parts.localization.live import LocalizationView  # noqa: PLC0415 - imports the filter

        return LocalizationView(offers.simulation)
    if offers.recording is None:
        return None
    from server.parts.localization.logged import LogLocalization  # noqa: PLC0415 - only of logs

    part = LogLocalization(offers.host, offers.recording)
    offers.plans["given"] = part.plan
    return part
