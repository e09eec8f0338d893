"""The contents of a recording in one .npz file next to its pack. They are read once, and stored with the log.

It contains no pickles: everything that is not an array of numbers is JSON in an array of bytes.
"""

from __future__ import annotations

import json
from dataclasses import asdict, astuple
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mapper.io.contents.log_lines import LogLine
from mapper.io.contents.model import CameraContents, Column, Contents, FrameEdge, Series, TopicContents
from server.library.packs.arrays import UNREADABLE, write_arrays

VERSION = 7


class StaleContentsError(Exception):
    """The file has another version, so the recording must be read again."""


def write_contents(contents: Contents, path: Path) -> None:
    """Write ``contents`` to ``path`` atomically: it is complete, or as it was before."""
    about = {
        "version": VERSION,
        "topics": [asdict(topic) for topic in contents.topics],
        "edges": [
            {
                "parent": edge.parent,
                "child": edge.child,
                "is_static": edge.is_static,
                "topic": edge.topic,
                "pose": edge.pose,
                "publishers": edge.publishers,
            }
            for edge in contents.edges
        ],
        "series": [
            {
                "topic": series.topic,
                "type": series.type,
                "columns": [asdict(column) for column in series.columns],
                "recorded": series.recorded,
            }
            for series in contents.series
        ],
        "notes": list(contents.notes),
        "lines": [astuple(line) for line in contents.lines],
        "lines_left_out": contents.lines_left_out,
        "cameras": [asdict(camera) for camera in contents.cameras],
    }
    arrays: dict[str, NDArray[Any]] = {}
    for n, edge in enumerate(contents.edges):
        arrays |= {f"edge{n}": edge.stamps_ns, f"pose_times{n}": edge.pose_stamps_ns, f"poses{n}": edge.poses}
    for n, series in enumerate(contents.series):
        arrays |= {f"times{n}": series.stamps_ns, f"values{n}": series.values}
    write_arrays(path, json.dumps(about), arrays)


def read_contents(path: Path) -> Contents:
    """Return what :func:`write_contents` wrote; raise :class:`StaleContentsError` for any other file or none."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about["version"] != VERSION:
                raise StaleContentsError(f"The file is of version {about['version']}, this is {VERSION}.")
            return Contents(
                topics=msgspec.convert(about["topics"], tuple[TopicContents, ...]),
                edges=tuple(
                    FrameEdge(
                        **edge | {"pose": tuple(edge["pose"]), "publishers": tuple(edge["publishers"])},
                        stamps_ns=arrays[f"edge{n}"],
                        pose_stamps_ns=arrays[f"pose_times{n}"],
                        poses=arrays[f"poses{n}"],
                    )
                    for n, edge in enumerate(about["edges"])
                ),
                series=tuple(
                    Series(
                        series["topic"],
                        series["type"],
                        msgspec.convert(series["columns"], tuple[Column, ...]),
                        arrays[f"times{n}"],
                        arrays[f"values{n}"],
                        recorded=series["recorded"],
                    )
                    for n, series in enumerate(about["series"])
                ),
                notes=tuple(about["notes"]),
                lines=tuple(LogLine(*line) for line in about["lines"]),
                lines_left_out=about["lines_left_out"],
                cameras=msgspec.convert(about["cameras"], tuple[CameraContents, ...]),
            )
    except UNREADABLE as error:
        raise StaleContentsError(f"{type(error).__name__}: {error}") from error
