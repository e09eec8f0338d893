"""Depth images of a TUM RGB-D benchmark folder, with poses interpolated from its ground truth."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.names import printable
from mapper.io.logs.text.lines import TextLines
from mapper.io.trajectories.lines import stamp_ns
from mapper.io.trajectories.tum import tum_rows

POSES = ("groundtruth.txt", "poses.txt", "trajectory.txt")
FARTHEST_NS = 100_000_000  #: maximum time from an image to the nearest pose


def tum_frames(folder: Path, limits: Limits) -> tuple[list[tuple[Path, int, NDArray[np.float64]]], list[str]]:
    """Return each image of ``depth.txt`` with its stamp, ns, and ``T_map_camera`` (4, 4), and notes.

    Poses are interpolated between those before and after an image, linearly in position and along the shortest
    rotation. Raises :class:`ReadError` for invalid lines, and for a folder without images or without poses for them.
    """
    images = _images(folder, limits)
    poses = next((folder / name for name in POSES if (folder / name).is_file()), None)
    if poses is None:
        raise ReadError("depth.no_poses", f"The folder {folder.name!r} has depth images but no {POSES[0]}.")
    stamps, values, _ = tum_rows(poses, limits)
    order = np.argsort(stamps, kind="stable")
    stamps, first = np.unique(stamps[order], return_index=True)
    values = values[order][first]
    times = np.array([stamp for _, stamp in images], dtype=np.int64)
    after = np.clip(np.searchsorted(stamps, times), 1, max(1, len(stamps) - 1))
    after = np.minimum(after, len(stamps) - 1)
    before = np.maximum(after - 1, 0)
    gap = np.minimum(np.abs(times - stamps[before]), np.abs(times - stamps[after]))
    inside = (times >= stamps[0]) & (times <= stamps[-1]) & (gap <= FARTHEST_NS)
    notes = []
    if not inside.all():
        name = images[int(np.argmin(inside))][0].name
        notes.append(
            f"{int((~inside).sum())} of {len(images)} depth images have no pose and are left out, the first {name}."
        )
    if not inside.any():
        raise ReadError(
            "depth.no_poses", f"No pose of {poses.name} is at the time of any of {len(images)} depth images."
        )
    matrices = poses_between(stamps, values, times[inside])
    frames = [image for image, is_inside in zip(images, inside, strict=True) if is_inside]
    return [(path, stamp, pose) for (path, stamp), pose in zip(frames, matrices, strict=True)], notes


def poses_between(
    stamps: NDArray[np.int64], values: NDArray[np.float64], times: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Interpolate poses (m, 4, 4) at stamps ``times`` (m,), ns, from ``values`` (n, 7) at ascending ``stamps``.

    Positions are interpolated linearly, rotations along the shortest arc; ``values`` are as in :func:`tum_rows`.
    """
    from scipy.spatial.transform import Rotation, Slerp  # noqa: PLC0415 # 0.2 s, only for folders of this kind

    seconds, at = (stamps - stamps[0]) * 1e-9, (times - stamps[0]) * 1e-9
    poses = np.tile(np.eye(4), (len(times), 1, 1))
    if len(stamps) == 1:
        poses[:, :3, :3] = Rotation.from_quat(values[0, 3:]).as_matrix()
        poses[:, :3, 3] = values[0, :3]
        return poses
    poses[:, :3, :3] = Slerp(seconds, Rotation.from_quat(values[:, 3:]))(at).as_matrix()
    for axis in range(3):
        poses[:, axis, 3] = np.interp(at, seconds, values[:, axis])
    return poses


def _images(folder: Path, limits: Limits) -> list[tuple[Path, int]]:
    lines = TextLines(folder / "depth.txt", limits)
    images: list[tuple[Path, int]] = []
    for number, text in lines:
        tokens = text.decode("utf-8", "replace").split(maxsplit=1)
        if not tokens or tokens[0].startswith("#"):
            continue
        if len(tokens) != 2:
            raise ReadError("depth.list", f"Line {number} of depth.txt must be a time and a file name.")
        name = PurePosixPath(tokens[1].strip())
        if name.is_absolute() or ".." in name.parts or not name.parts:
            raise ReadError("depth.list", f"Line {number} of depth.txt names a file outside of the folder.")
        path = folder / name
        if not path.is_file():
            raise ReadError(
                "depth.list", f"Line {number} of depth.txt: there is no file {printable(str(name)[:80])!r}."
            )
        images.append((path, stamp_ns(tokens[0], number, "depth.txt")))
        if len(images) > limits.max_depth_frames:
            raise LimitError("depth.too_many", f"The folder has more than {limits.max_depth_frames} depth images.")
    if not images:
        raise ReadError("depth.none", "depth.txt lists no depth images.")
    return images
