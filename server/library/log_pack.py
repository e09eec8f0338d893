"""A log as arrays in one .npz file, from which it is loaded without running the reader again.

No pickle on either side: everything that is not an array of numbers is JSON in an array of bytes.
"""

from __future__ import annotations

import json
import uuid
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.errors import MapperError
from mapper.sensors.scan import ScanLog, Topic, Trajectory

VERSION = 3


class StalePackError(Exception):
    """The file is no pack of this version: read the log again."""


def write_pack(log: ScanLog, path: Path) -> None:
    """Write ``log`` to ``path`` atomically: it is there whole, or as it was before."""
    about = {
        "version": VERSION,
        "angle_min": float(log.angle_min),
        "angle_increment": float(log.angle_increment),
        "range_min": float(log.range_min),
        "range_max": float(log.range_max) if np.isfinite(log.range_max) else None,
        "mount": [float(v) for v in log.mount],
        "upside_down": bool(log.upside_down),
        "bearings": None if log.bearings is None else log.bearings.tolist(),
        "beam_width": float(log.beam_width),
        "frame_id": log.frame_id,
        "time_increment": float(log.time_increment),
        "scan_time": float(log.scan_time),
        "name": log.name,
        "format": log.format,
        "notes": list(log.notes),
        "topics": [asdict(topic) for topic in log.topics],
        "trajectories": [
            {
                "name": name,
                "description": one.description,
                "frame_id": one.frame_id,
                "child_frame_id": one.child_frame_id,
                "is_placeholder": one.is_placeholder,
            }
            for name, one in log.trajectories.items()
        ],
    }
    fresh = path.with_name(f"{path.name}.{uuid.uuid4().hex}.new")
    try:
        with fresh.open("wb") as file:
            np.savez(
                file,
                about=np.frombuffer(json.dumps(about, allow_nan=False).encode(), dtype=np.uint8),
                ranges=log.ranges,
                stamps_ns=log.stamps_ns,
                poses=np.stack([trajectory.poses for trajectory in log.trajectories.values()]),
            )
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)


def read_pack(path: Path) -> ScanLog:
    """Return the log that :func:`write_pack` wrote; raise :class:`StalePackError` for any other file or none."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about["version"] != VERSION:
                raise StalePackError(f"The pack is of version {about['version']}, this is {VERSION}.")
            range_max = about["range_max"]
            return ScanLog(
                ranges=arrays["ranges"],
                angle_min=about["angle_min"],
                angle_increment=about["angle_increment"],
                range_min=about["range_min"],
                range_max=float("inf") if range_max is None else range_max,
                stamps_ns=arrays["stamps_ns"],
                trajectories={
                    one.pop("name"): Trajectory(poses, **one)
                    for one, poses in zip(about["trajectories"], arrays["poses"], strict=True)
                },
                mount=tuple(about["mount"]),
                upside_down=about["upside_down"],
                bearings=None if about["bearings"] is None else np.array(about["bearings"], dtype=np.float64),
                beam_width=about["beam_width"],
                frame_id=about["frame_id"],
                time_increment=about["time_increment"],
                scan_time=about["scan_time"],
                name=about["name"],
                format=about["format"],
                notes=tuple(about["notes"]),
                topics=tuple(topic_from_json(one) for one in about["topics"]),
            )
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, MapperError) as error:
        raise StalePackError(f"{type(error).__name__}: {error}") from error


def topic_from_json(values: dict[str, Any]) -> Topic:
    """Return the topic that ``asdict`` made ``values`` of. Raises ``TypeError`` for anything else."""
    mount = values.get("mount")
    return Topic(**(values | {"mount": None if mount is None else tuple(mount)}))


def nbytes(log: ScanLog) -> int:
    """Return how much memory the log's arrays take."""
    poses = {id(trajectory.poses): trajectory.poses.nbytes for trajectory in log.trajectories.values()}
    return int(log.ranges.nbytes + log.stamps_ns.nbytes + sum(poses.values()))
