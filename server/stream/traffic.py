"""Counts of the data that the streams send. The service needs them at its start, before it imports the hub."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Traffic:
    """Binary frames, bytes and tiles sent, for the metrics."""

    frames: int = 0
    bytes: int = 0
    tiles: int = 0
