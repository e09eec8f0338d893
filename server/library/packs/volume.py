"""Source of a 3D map as one .npz file without pickles: the scans of clouds, or an octree."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.camera import Intrinsics
from mapper.volume import Octree, OctreeFile
from mapper.volume.scans.depth_sequence import DepthSequence
from mapper.volume.scans.scan_sequence import FIELDS, ScanSequence
from server.library.packs.arrays import UNREADABLE, write_arrays
from server.library.packs.log import StalePackError

VERSION = 3
_SCANS, _OCTREE = "scans in 3D", "octree"

VolumeSource = ScanSequence | OctreeFile


def write_volume_pack(source: VolumeSource, path: Path) -> None:
    """Write ``source`` to ``path`` atomically. Raises :class:`OSError`."""
    arrays: dict[str, NDArray[Any]]
    if isinstance(source, OctreeFile):
        about: dict[str, Any] = {
            "kind": _OCTREE, "ending": source.kind, "header": source.header.decode("latin-1"),
            "resolution": source.tree.resolution, "notes": list(source.notes),
        }  # fmt: skip
        arrays = {"values": source.tree.values, "masks": source.tree.masks}
    else:
        about = {"kind": _SCANS, "format": source.kind, "notes": list(source.notes)}
        arrays = {
            "points": source.points, "starts": source.starts, "origins": source.origins,
            "stamps": source.stamps_ns, "offset": source.offset, **source.fields,
        }  # fmt: skip
        if source.depth is not None:
            about |= {"camera": asdict(source.depth.camera), "unit": source.depth.unit}
            arrays |= {"images": source.depth.images, "poses": source.depth.poses}
    write_arrays(path, json.dumps(about | {"version": VERSION}), arrays)


def read_volume_pack(path: Path) -> VolumeSource:
    """Return what :func:`write_volume_pack` wrote. Raises :class:`StalePackError` for any other file, or none."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if about.get("kind") not in (_SCANS, _OCTREE) or about["version"] != VERSION:
                raise StalePackError("The pack holds no 3D map.")
            if about["kind"] == _OCTREE:
                tree = Octree(float(about["resolution"]), arrays["values"], arrays["masks"])
                return OctreeFile(about["ending"], about["header"].encode("latin-1"), tree, tuple(about["notes"]))
            depth = None
            if "camera" in about:
                depth = DepthSequence(
                    Intrinsics(**about["camera"]), float(about["unit"]), arrays["images"], arrays["poses"]
                )
            return ScanSequence(
                about["format"], arrays["points"], arrays["starts"], arrays["origins"], arrays["stamps"],
                arrays["offset"], {name: arrays[name] for name in FIELDS if name in arrays}, tuple(about["notes"]),
                depth,
            )  # fmt: skip
    except UNREADABLE as error:
        raise StalePackError(f"{type(error).__name__}: {error}") from error
