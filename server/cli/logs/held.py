"""Output of ``info`` besides scans: topics, clouds and IMUs of a recording, cloud files, folders of depth images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import typer
from msgspec import Struct, to_builtins
from numpy.typing import NDArray

from mapper.io.clouds import read_cloud, read_depth_folder, read_scan_graph
from mapper.io.clouds.describe import CloudDescription, description
from mapper.io.contents.inspection import Held
from mapper.io.contents.model import TopicContents
from mapper.sensors.streams import CloudStream, ImuStream
from mapper.volume.scans.map_offset import offset_of
from server.cli.common import print_json, print_notes, progress_bar, refusing


class CloudFacts(Struct):
    """Properties of the clouds of one topic, from the first of them."""

    topic: str
    count: int
    frame: str
    height: int
    width: int
    fields: list[str]
    has_times: bool
    mount: list[float] | None


class ImuFacts(Struct):
    """Properties of an IMU, from the first messages of its topic."""

    topic: str
    count: int
    frame: str
    has_orientation: bool
    mount: list[float] | None


def print_held(path: Path, content: Held, *, as_json: bool) -> None:
    """Print a recording without scans."""
    clouds, imus = clouds_facts(content.clouds), imus_facts(content.imus)
    notes = [*([content.no_scans] if content.no_scans else []), *content.contents.notes]
    if as_json:
        print_json(
            {
                "name": path.name,
                "format": content.format,
                "scans": 0,
                "contents": contents_facts(content.contents.topics),
                "clouds": to_builtins(clouds),
                "imus": to_builtins(imus),
                "notes": notes,
            }
        )
        return
    typer.echo(f"{path.name}: {content.format}")
    typer.echo("  no scans of which a map can be made")
    for topic in content.contents.topics:
        typer.echo(f"    {topic_line(topic)}")
    for line in (*map(stream_line, clouds), *map(stream_line, imus)):
        typer.echo(f"  {line}")
    print_notes(notes)


def contents_facts(topics: Sequence[TopicContents]) -> list[dict[str, object]]:
    """Return the known facts about every topic, for JSON."""
    return [asdict(topic) | {"span_s": topic.span_s, "rate_hz": topic.rate_hz} for topic in topics]


def topic_line(topic: TopicContents) -> str:
    """Return a line with the contents, size, rate and span of one topic."""
    return f"{topic.name}: {topic.messages} × {topic.type}{size_line(topic)}"


def clouds_facts(clouds: Mapping[str, CloudStream]) -> list[CloudFacts]:
    """Return the properties of a recording's clouds, from the first of each topic."""
    facts = []
    for stream in clouds.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        height, width = first.shape or (1, len(first))
        facts.append(
            CloudFacts(
                topic=stream.topic,
                count=stream.count,
                frame=first.frame_id,
                height=height,
                width=width,
                fields=list(first.fields),
                has_times=first.times is not None,
                mount=_place(stream.mounts(first.frame_id, np.array([first.stamp_ns]))),
            )
        )
    return facts


def imus_facts(imus: Mapping[str, ImuStream]) -> list[ImuFacts]:
    """Return the properties of a recording's IMUs, from the first messages of each topic."""
    facts = []
    for stream in imus.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        has_orientation = bool(np.isfinite(first.orientation).any())
        mount = _place(stream.mounts(first.frame_id, first.stamps_ns[:1]))
        facts.append(ImuFacts(stream.topic, stream.count, first.frame_id, has_orientation, mount))
    return facts


def _place(mounts: NDArray[np.float64] | None) -> list[float] | None:
    """Return the position x, y, z (m) of the first of the mounts (n, 4, 4)."""
    return None if mounts is None else [round(float(value), 6) for value in mounts[0, :3, 3]]


def stream_line(stream: CloudFacts | ImuFacts) -> str:
    """Return a line with the properties of one topic's clouds or IMU."""
    at = "" if stream.mount is None else f" at {', '.join(f'{value:g}' for value in stream.mount)} m"
    facts = f"frame {stream.frame}{at}"
    if isinstance(stream, ImuFacts):
        oriented = ", with orientation" if stream.has_orientation else ""
        return f"IMU {stream.topic}: {stream.count} messages, {facts}{oriented}"
    times = ", a time for each point" if stream.has_times else ""
    fields = ", ".join(["x, y, z", *stream.fields])
    return (
        f"clouds {stream.topic}: {stream.count} of {stream.width} × {stream.height} points ({fields}){times}, {facts}"
    )


def size_line(topic: TopicContents, *, with_rate: bool = True) -> str:
    """Return a line with the size, span and rate of a topic."""
    size, unit = float(topic.bytes), "B"
    for larger in ("kB", "MB", "GB"):
        if size >= 1000.0:
            size, unit = size / 1000.0, larger
    rate = f", {topic.rate_hz:.1f} Hz" if with_rate and topic.rate_hz is not None else ""
    return f"{rate}, {size:.{0 if unit == 'B' else 1}f} {unit} in {topic.span_s:.1f} s"


def print_cloud(path: Path, kind: str, *, as_json: bool) -> None:
    """Print the properties of the cloud, or the scan graph, at ``path``."""
    with refusing(path), progress_bar("Reading") as bar:
        scans = sum(1 for _ in read_scan_graph(path)) if kind == "scan graph" else None
        cloud = read_cloud(path, progress=bar)
        facts = description(cloud)
    offset = offset_of(cloud.points[cloud.finite]) if cloud.finite.any() else None
    if offset is not None and offset.any():
        place = ", ".join(f"{value:,.0f}" for value in offset)
        facts.notes.append(f"The coordinates are far from 0: a 3D map of them has its origin at {place} m.")
    if as_json:
        print_json({"name": path.name, "format": kind, "scans": scans} | asdict(facts))
        return
    typer.echo(f"{path.name}: {kind}" + ("" if scans is None else f" of {scans} scan{'s' if scans != 1 else ''}"))
    for line in cloud_lines(facts):
        typer.echo(f"  {line}")
    print_notes(facts.notes)


def cloud_lines(facts: CloudDescription) -> list[str]:
    """Return the facts about a cloud, one per line."""
    rows = "" if facts.organised is None else f", {facts.organised[1]} × {facts.organised[0]}"
    parts = [f"{facts.points} points{rows}"]
    if facts.low is not None and facts.high is not None:
        size = " × ".join(f"{high - low:.2f}" for low, high in zip(facts.low, facts.high, strict=True))
        parts.append(f"box {_point(facts.low)} to {_point(facts.high)}: {size} m")
    if facts.spacing_m is not None:
        parts.append(f"spacing {facts.spacing_m:.3g} m, the median distance to the nearest point")
    fields = ["x, y, z", *(_field(name, kind) for name, kind in facts.fields.items())]
    parts.append(f"fields {', '.join(fields)}" + (", a time for each point" if facts.has_times else ""))
    if facts.sensor is not None:
        parts.append(f"sensor at {_point(facts.sensor)}")
    return parts


def _field(name: str, kind: list[str | int]) -> str:
    return f"{name} ({' × '.join(map(str, [*kind[1:], kind[0]]))})"


def _point(values: list[float]) -> str:
    return f"({', '.join(f'{value:.3f}' for value in values)})"


def print_depth_folder(path: Path, *, as_json: bool) -> None:
    """Print the properties of the folder of depth images at ``path``."""
    with refusing(path):
        folder = read_depth_folder(path)
        first = folder.frames[0].read()
    places = np.array([frame.pose[:3, 3] for frame in folder.frames])
    length = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    camera, depths = folder.camera, _range_of(first)
    if as_json:
        print_json(
            {
                "name": path.name,
                "format": "folder of depth images",
                "frames": len(folder),
                "camera": asdict(camera),
                "way_m": length,
                "first_depth_m": depths,
                "notes": list(folder.notes),
            }
        )
        return
    typer.echo(f"{path.name}: folder of depth images")
    typer.echo(f"  {len(folder)} images of {camera.width} × {camera.height} pixels, along {length:.2f} m")
    typer.echo(f"  focal lengths {camera.fx:g}, {camera.fy:g}, centre {camera.cx:g}, {camera.cy:g} pixels")
    if depths is not None:
        low, high, share = depths
        typer.echo(f"  depths of the first image {low:.2f} to {high:.2f} m, {100 * share:.0f} % of its pixels")
    print_notes(folder.notes)


def _range_of(depth: np.ndarray[Any, np.dtype[np.float32]]) -> list[float] | None:
    """Return the least and the greatest depth, metres, and the share of pixels with a depth; None without any."""
    known = depth[np.isfinite(depth)]
    return [float(known.min()), float(known.max()), len(known) / depth.size] if len(known) else None
