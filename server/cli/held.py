"""Contents of a recording besides scans, as ``info`` prints them: topics, clouds, IMUs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from server.cli.common import print_json

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mapper.io.contents.inspection import Held
    from mapper.io.contents.model import TopicContents
    from mapper.sensors.streams import CloudStream, ImuStream


def print_held(path: Path, held: Held, *, as_json: bool) -> None:
    """Print a recording that has no scans."""
    facts: dict[str, Any] = {
        "name": path.name,
        "format": held.format,
        "scans": 0,
        "contents": contents_facts(held.contents.topics),
        "clouds": clouds_facts(held.clouds),
        "imus": imus_facts(held.imus),
        "notes": [*([held.no_scans] if held.no_scans else []), *held.contents.notes],
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{path.name}: {held.format}")
    typer.echo("  no scans of which a map can be made")
    for one in facts["contents"]:
        typer.echo(f"    {held_line(one)}")
    for one in [*facts["clouds"], *facts["imus"]]:
        typer.echo(f"  {stream_line(one)}")
    for note in facts["notes"]:
        typer.echo(f"  note: {note}")


def contents_facts(topics: Sequence[TopicContents]) -> list[dict[str, Any]]:
    """Return what is known of every topic, for JSON."""
    return [asdict(one) | {"span_s": one.span_s, "rate_hz": one.rate_hz} for one in topics]


def held_line(topic: dict[str, Any]) -> str:
    """Say what one topic holds, how much, how often and for how long."""
    return f"{topic['name']}: {topic['messages']} × {topic['type']}{size_line(topic)}"


def clouds_facts(clouds: Mapping[str, CloudStream]) -> list[dict[str, Any]]:
    """Return what the clouds of a recording are, by the first of each topic."""
    found = []
    for stream in clouds.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        said = {"height": first.shape[0], "width": first.shape[1]} if first.shape else {}
        fields = {"fields": list(first.fields), "has_times": first.times is not None}
        mount = _place(stream.mounts(first.frame_id, np.array([first.stamp_ns])))
        found.append(
            {"topic": stream.topic, "count": stream.count, "frame": first.frame_id, **said, **fields, "mount": mount}
        )
    return found


def imus_facts(imus: Mapping[str, ImuStream]) -> list[dict[str, Any]]:
    """Return what the IMUs of a recording are, by the first messages of each topic."""
    found = []
    for stream in imus.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        has_orientation = bool(np.isfinite(first.orientation).any())
        mount = _place(stream.mounts(first.frame_id, first.stamps_ns[:1]))
        found.append(
            {"topic": stream.topic, "count": stream.count, "frame": first.frame_id,
             "has_orientation": has_orientation, "mount": mount}
        )  # fmt: skip
    return found


def _place(mounts: NDArray[np.float64] | None) -> list[float] | None:
    """Return the place x, y, z (m) of the first of the mounts (n, 4, 4)."""
    return None if mounts is None else [round(float(value), 6) for value in mounts[0, :3, 3]]


def stream_line(one: dict[str, Any]) -> str:
    """Say what the clouds or the IMU of one topic are."""
    at = "" if one["mount"] is None else f" at {', '.join(f'{value:g}' for value in one['mount'])} m"
    said = f"frame {one['frame']}{at}"
    if "fields" not in one:
        return f"IMU {one['topic']}: {one['count']} messages, {said}" + (
            ", with orientation" if one["has_orientation"] else ""
        )
    times = ", a time for each point" if one["has_times"] else ""
    fields = ", ".join(["x, y, z", *one["fields"]])
    return f"clouds {one['topic']}: {one['count']} of {one['width']} × {one['height']} points ({fields}){times}, {said}"


def size_line(topic: dict[str, Any], *, with_rate: bool = True) -> str:
    """Say how large a topic is, over which time, and how often it comes."""
    size, unit = float(topic["bytes"]), "B"
    for larger in ("kB", "MB", "GB"):
        if size >= 1000.0:
            size, unit = size / 1000.0, larger
    rate = f", {topic['rate_hz']:.1f} Hz" if with_rate and topic["rate_hz"] is not None else ""
    return f"{rate}, {size:.{0 if unit == 'B' else 1}f} {unit} in {topic['span_s']:.1f} s"
