"""Folders of depth images with poses and intrinsics, in the formats of 7-Scenes and the TUM RGB-D benchmark.

Source: the page of Microsoft's 7-Scenes (``frame-XXXXXX.depth.png``, millimetres, 65535 invalid;
``frame-XXXXXX.pose.txt``, camera to world, 4 × 4; principal point (320, 240), focal length 585); the TUM RGB-D
benchmark's "File Formats" (``depth.txt``: timestamp and file name; 5000 units per metre, 0 invalid;
``groundtruth.txt``) and "Intrinsic Camera Calibration" (ROS default 525, 525, 319.5, 239.5).
"""

from __future__ import annotations

import math
import os
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.clouds.content import content
from mapper.io.clouds.numbers import table
from mapper.io.clouds.tum_poses import tum_frames
from mapper.sensors.camera import Intrinsics
from mapper.sensors.depth_image import DepthFolder, DepthFrame

NO_DEPTH = (0, 65535)  #: invalid values: 0 in TUM and most cameras, 65535 in 7-Scenes


def image_size(path: Path) -> tuple[int, int]:
    """Return the width and height of a depth image, from its header. Raises :class:`ReadError`."""
    try:
        with Image.open(path, formats=("PNG",)) as image:
            return image.size
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ReadError("depth.image", f"{path.name} is not a PNG image.") from error


def read_depth(path: Path, camera: Intrinsics, unit: float, limits: Limits) -> NDArray[np.float32]:
    """Return the depths (height, width), metres, from a file in units of ``unit`` metres; NaN for no depth.

    Raises :class:`ReadError` for a file that is not a 16-bit grey PNG, ends early, or differs in size from the camera's
    images.
    """
    width, height = image_size(path)
    if width * height > limits.max_depth_pixels:
        raise ReadError(
            "depth.size", f"{path.name} has {width} × {height} pixels, more than {limits.max_depth_pixels}."
        )
    try:
        with Image.open(path, formats=("PNG",)) as image:
            mode = image.mode
            raw = np.asarray(image)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ReadError("depth.image", f"{path.name} is damaged: its pixels cannot be unpacked.") from error
    if not mode.startswith("I") or raw.ndim != 2:
        raise ReadError(
            "depth.image", f"{path.name} is not a depth image: it must be grey with 16 bits a pixel, not {mode}."
        )
    try:
        camera.check_size(raw, "intrinsics")
    except ConfigError as error:
        raise ReadError("depth.size", f"{path.name}: {error.message}.") from error
    depths = raw.astype(np.float32) * np.float32(unit)
    for value in NO_DEPTH:
        depths[raw == value] = np.nan
    return depths


DEPTH_END, POSE_END = ".depth.png", ".pose.txt"
SEVEN_SCENES_UNIT, TUM_UNIT = 0.001, 1.0 / 5000.0  #: metres per unit
INTRINSICS = ("camera-intrinsics.txt", "intrinsics.txt", "camera.txt")
USUAL_SIZE = (640, 480)
SEVEN_SCENES_CAMERA, TUM_CAMERA = (585.0, 585.0, 320.0, 240.0), (525.0, 525.0, 319.5, 239.5)
TAKEN_NOTE = "The folder has no {}: the data set’s own are taken, fx fy cx cy = {}."
NO_POSE_NOTE = "{n} of {all} depth images have no pose and are left out, the first {first}."


def is_depth_folder(path: Path) -> bool:
    """Return whether a folder has depth images that :func:`read_depth_folder` can read."""
    return path.is_dir() and ((path / "depth.txt").is_file() or any(path.glob(f"*{DEPTH_END}")))


def read_depth_folder(path: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS) -> DepthFolder:
    """Return the depth images of the folder ``path``, with poses and intrinsics; images are read on demand.

    Intrinsics come from one of :data:`INTRINSICS`, a 3 × 3 matrix or the four numbers fx fy cx cy; without that file
    they are those of the data set's page, with a note. Raises :class:`ReadError` for a folder without depth images, for
    invalid intrinsics and for poses that are not rotations, and :class:`LimitError`.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise ReadError("depth.folder", f"There is no folder {folder.name!r}.")
    if (folder / "depth.txt").is_file():
        listed, usual, unit = tum_frames(folder, limits), TUM_CAMERA, TUM_UNIT
    else:
        listed, usual, unit = _seven_scenes(folder, limits), SEVEN_SCENES_CAMERA, SEVEN_SCENES_UNIT
    images, notes = listed
    width, height = image_size(images[0][0])
    camera, camera_notes = _camera(folder, (width, height), usual, limits)
    frames = []
    for image, stamp_ns, pose in images:
        try:
            frames.append(DepthFrame(image.name, stamp_ns, pose, partial(read_depth, image, camera, unit, limits)))
        except ConfigError as error:
            raise ReadError("depth.pose", error.message) from error
    return DepthFolder(camera, tuple(frames), (*camera_notes, *notes), unit)


Found = tuple[list[tuple[Path, int, NDArray[np.float64]]], list[str]]


def _seven_scenes(folder: Path, limits: Limits) -> Found:
    images = sorted(folder.glob(f"*{DEPTH_END}"))
    if not images:
        raise ReadError("depth.none", f"The folder {folder.name!r} has no depth images (*{DEPTH_END}, or depth.txt).")
    if len(images) > limits.max_depth_frames:
        raise LimitError("depth.too_many", f"The folder has more than {limits.max_depth_frames} depth images.")
    listed, without = [], []
    for image in images:
        pose_file = image.with_name(image.name.removesuffix(DEPTH_END) + POSE_END)
        if not pose_file.is_file():
            without.append(image.name)
            continue
        listed.append((image, 0, _matrix(pose_file, 4, limits)))
    if not listed:
        raise ReadError("depth.no_poses", f"None of the folder’s {len(images)} depth images has a pose (*{POSE_END}).")
    notes = [NO_POSE_NOTE.format(n=len(without), all=len(images), first=without[0])] if without else []
    return listed, notes


def _matrix(path: Path, side: int, limits: Limits) -> NDArray[np.float64]:
    try:
        matrix = table(content(path, limits), None, None, None, limits)
    except ReadError as error:
        raise ReadError(error.code, f"{path.name}: {error.message}") from error
    if matrix.shape != (side, side):
        raise ReadError(
            "depth.matrix", f"{path.name} holds {matrix.shape[0]} × {matrix.shape[1]} numbers, not {side} × {side}."
        )
    return matrix


def _camera(
    folder: Path, size: tuple[int, int], usual: tuple[float, float, float, float], limits: Limits
) -> tuple[Intrinsics, list[str]]:
    file = next((folder / name for name in INTRINSICS if (folder / name).is_file()), None)
    if file is None:
        if size != USUAL_SIZE:
            raise ReadError(
                "depth.no_intrinsics",
                f"The folder has no {INTRINSICS[0]}, and for images of {size[0]} × {size[1]} pixels none are known.",
            )
        return Intrinsics(*size, *usual), [TAKEN_NOTE.format(INTRINSICS[0], ", ".join(f"{value:g}" for value in usual))]
    try:
        numbers = table(content(file, limits), None, None, None, limits)
    except ReadError as error:
        raise ReadError(error.code, f"{file.name}: {error.message}") from error
    if numbers.shape == (3, 3):
        fx, fy, cx, cy = numbers[0, 0], numbers[1, 1], numbers[0, 2], numbers[1, 2]
    elif numbers.size >= 4 and numbers.shape[0] == 1:
        fx, fy, cx, cy = numbers[0, :4]
    else:
        raise ReadError("depth.intrinsics", f"{file.name} is neither a matrix of 3 × 3 nor the numbers fx fy cx cy.")
    try:
        camera = Intrinsics(*size, float(fx), float(fy), float(cx), float(cy))
    except ConfigError as error:
        raise ReadError("depth.intrinsics", f"{file.name}: {error.message}") from error
    if not (0.0 <= cx <= size[0] and 0.0 <= cy <= size[1]) or math.hypot(fx, fy) > 1e5:
        raise ReadError(
            "depth.intrinsics",
            f"{file.name} is of images of another size: its centre {cx:g}, {cy:g} is outside of the "
            f"{size[0]} × {size[1]} pixels of {folder.name}'s images.",
        )
    return camera, []
