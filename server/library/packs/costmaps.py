"""The costmaps of a recording as one file, from which they are loaded without reading the recording again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.costmap.costs import INSCRIBED, LETHAL
from mapper.grid import GridGeometry
from mapper.io.logs.summary import NO_SCANS, LogSummary, time_without_gaps
from mapper.sensors.scan import Topic
from server.library.packs.arrays import UNREADABLE, write_arrays
from server.library.packs.log import StalePackError

if TYPE_CHECKING:
    from mapper.io.costmaps import CostmapStream

VERSION = 1
MOST_LOOKED_AT = 50
_KIND = "costmaps"


def write_costmap_pack(streams: Mapping[str, CostmapStream], path: Path) -> None:
    """Write the costmaps to ``path`` atomically."""
    items = []
    for topic, stream in streams.items():
        for costmap in stream.kept:
            fields = asdict(costmap)
            geometry = costmap.geometry
            fields |= {"packed": len(costmap.packed), "topic": topic}
            fields["geometry"] = [geometry.resolution, geometry.rows, geometry.cols, list(geometry.origin)]
            items.append(fields)
    about = {"version": VERSION, "kind": _KIND, "items": items}
    data = b"".join(costmap.packed for stream in streams.values() for costmap in stream.kept)
    write_arrays(path, json.dumps(about), {"costs": np.frombuffer(data, dtype=np.uint8)})


def read_costmap_pack(path: Path) -> dict[str, CostmapStream]:
    """Return what :func:`write_costmap_pack` wrote, by topic. Raises :class:`StalePackError` for any other file."""
    from mapper.io.costmaps import CostmapStream, KeptCostmap  # noqa: PLC0415 - few logs have them

    streams: dict[str, CostmapStream] = {}
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about, data = json.loads(arrays["about"].tobytes()), arrays["costs"].tobytes()
        if about.get("kind") != _KIND or about["version"] != VERSION:
            raise StalePackError("The pack holds no costmaps.")
        begin = 0
        for item in about["items"]:
            resolution, rows, cols, origin = item.pop("geometry")
            stream = streams.setdefault(item["topic"], CostmapStream(item.pop("topic")))
            end = begin + item["packed"]
            geometry = GridGeometry(resolution, rows, cols, tuple(origin))
            stream.keep(KeptCostmap(**item | {"geometry": geometry, "packed": data[begin:end]}))
            begin = end
    except UNREADABLE as error:
        raise StalePackError(f"{type(error).__name__}: {error}") from error
    return streams


def costmap_codes(streams: Mapping[str, CostmapStream]) -> UInt8Array:
    """Return the codes of a picture for the card: the costmap with the most obstacles.

    It is one of the topic with the most costmaps. For a long recording, :data:`MOST_LOOKED_AT` costmaps, spread evenly
    over it, are considered.
    """
    stream = max(streams.values(), key=len)
    at = np.unique(np.linspace(0, len(stream) - 1, min(len(stream), MOST_LOOKED_AT)).round().astype(int))
    costs = max((stream[int(k)].costs for k in at), key=lambda sheet: np.count_nonzero(sheet == LETHAL))
    from mapper.replay.overview import cells_overview  # noqa: PLC0415 - few recordings have costmaps

    return cells_overview(costs < INSCRIBED, (costs == INSCRIBED) | (costs == LETHAL))


def summarise_costmaps(streams: Mapping[str, CostmapStream], name: str) -> LogSummary:
    """Return the figures of a recording with costmaps and no scans; times are those of the topic with most."""
    first = max(streams.values(), key=len)
    time, duration_s = time_without_gaps(first.received_ns)
    bad = sum(stream.bad for stream in streams.values())
    notes = ["The recording has costmaps and no scans: they are shown, and no map is made."]
    notes += [f"{bad} costmaps could not be read."] if bad else []
    return replace(
        NO_SCANS,
        name=name,
        format="costmaps",
        duration_s=duration_s,
        notes=tuple(notes),
        time=time,
        topics=tuple(
            Topic(topic, "nav2_msgs/Costmap", len(stream), ", ".join(stream.frames) or None)
            for topic, stream in streams.items()
        ),
        costmaps=len(first),
    )
