"""Logs of a library for the tests of its fleet."""

from __future__ import annotations

from server.library.library import Library
from server.library.logs.records import Record
from tests.server.library.kept import settled
from tests.server.library.small_logs import carmen, in_pieces


async def uploads(library: Library, *scans: int) -> list[Record]:
    """Return logs of so many scans each, uploaded and read."""
    made = []
    for count in scans:
        record = await library.put("ann", f"{count}.log", in_pieces(carmen(count)))
        made.append(await settled(library, "ann", record.id))
    return made


def counts(library: Library, logs: list[Record]) -> dict[str, int]:
    """Return how many of the logs are in each state of the fleet, without states of none."""
    return {name: count for name, count in library.fleet.state(logs).counts.items() if count}
