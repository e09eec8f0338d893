"""``info`` of point clouds, scan graphs and folders of depth images."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import typer

from server.cli.common import print_json, progress_bar, refusing


def print_cloud(path: Path, kind: str, *, as_json: bool) -> None:
    """Print what the cloud, or the scan graph, at ``path`` is."""
    from mapper.io.clouds import read_cloud, read_scan_graph  # noqa: PLC0415 - start-up
    from mapper.io.clouds.describe import description  # noqa: PLC0415 - start-up
    from mapper.volume.scans.map_offset import offset_of  # noqa: PLC0415 - start-up

    with refusing(path), progress_bar("Reading") as bar:
        scans = sum(1 for _ in read_scan_graph(path)) if kind == "scan graph" else None
        facts: dict[str, Any] = {"name": path.name, "format": kind, "scans": scans}
        cloud = read_cloud(path, progress=bar)
        facts |= description(cloud)
    offset = offset_of(cloud.points[cloud.finite]) if cloud.finite.any() else None
    if offset is not None and offset.any():
        place = ", ".join(f"{value:,.0f}" for value in offset)
        facts["notes"].append(f"The coordinates are far from 0: a 3D map of them has its origin at {place} m.")
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{path.name}: {kind}" + ("" if scans is None else f" of {scans} scan{'s' if scans != 1 else ''}"))
    for line in cloud_lines(facts):
        typer.echo(f"  {line}")


def cloud_lines(facts: dict[str, Any]) -> list[str]:
    """Say what is known of a cloud, a line for each fact."""
    rows = "" if facts["organised"] is None else f", {facts['organised'][1]} × {facts['organised'][0]}"
    said = [f"{facts['points']} points{rows}"]
    if facts["low"] is not None:
        size = " × ".join(f"{high - low:.2f}" for low, high in zip(facts["low"], facts["high"], strict=True))
        said.append(f"box {_place(facts['low'])} to {_place(facts['high'])}: {size} m")
    if facts["spacing_m"] is not None:
        said.append(f"spacing {facts['spacing_m']:.3g} m, the median distance to the nearest point")
    fields = ["x, y, z", *(_field(name, kind) for name, kind in facts["fields"].items())]
    said.append(f"fields {', '.join(fields)}" + (", a time for each point" if facts["has_times"] else ""))
    if facts["sensor"] is not None:
        said.append(f"sensor at {_place(facts['sensor'])}")
    return said + [f"note: {note}" for note in facts["notes"]]


def _field(name: str, kind: list[Any]) -> str:
    return f"{name} ({' × '.join(map(str, [*kind[1:], kind[0]]))})"


def _place(values: list[float]) -> str:
    return f"({', '.join(f'{value:.3f}' for value in values)})"


def print_depth_folder(path: Path, *, as_json: bool) -> None:
    """Print what the folder of depth images at ``path`` is."""
    from mapper.io.clouds import read_depth_folder  # noqa: PLC0415 - start-up

    with refusing(path):
        folder = read_depth_folder(path)
        first = folder.frames[0].read()
    places = np.array([frame.pose[:3, 3] for frame in folder.frames])
    facts: dict[str, Any] = {
        "name": path.name,
        "format": "folder of depth images",
        "frames": len(folder),
        "camera": asdict(folder.camera),
        "way_m": float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum()),
        "first_depth_m": _range_of(first),
        "notes": list(folder.notes),
    }
    if as_json:
        print_json(facts)
        return
    camera, seen = folder.camera, facts["first_depth_m"]
    typer.echo(f"{path.name}: {facts['format']}")
    typer.echo(f"  {len(folder)} images of {camera.width} × {camera.height} pixels, along {facts['way_m']:.2f} m")
    typer.echo(f"  focal lengths {camera.fx:g}, {camera.fy:g}, centre {camera.cx:g}, {camera.cy:g} pixels")
    if seen is not None:
        typer.echo(f"  depths of the first image {seen[0]:.2f} to {seen[1]:.2f} m, {100 * seen[2]:.0f} % of its pixels")
    for note in folder.notes:
        typer.echo(f"  note: {note}")


def _range_of(depth: np.ndarray[Any, np.dtype[np.float32]]) -> list[float] | None:
    """Return the least and the largest depth, metres, and the share of pixels that have one; None where none has."""
    known = depth[np.isfinite(depth)]
    return [float(known.min()), float(known.max()), len(known) / depth.size] if len(known) else None
